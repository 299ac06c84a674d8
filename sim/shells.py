"""What the UR10 looks like and collides with: cans, tubes and lids from its dimensions, or the maker's meshes."""

from dataclasses import dataclass

import mujoco

ALUMINIUM = (0.66, 0.68, 0.70, 1.0)
LID_BLUE = (0.29, 0.55, 0.75, 1.0)
JOINT_GREY = (0.33, 0.34, 0.36, 1.0)

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Shell:
    """A cylinder from `start` to `end` in the link's frame, metres; `solid` ones collide (as capsules for tubes)."""

    start: Point
    end: Point
    radius: float
    rgba: tuple[float, float, float, float] = ALUMINIUM
    solid: bool = False
    rounded: bool = False

    def add_to(self, body: mujoco.MjsBody) -> None:
        """Adds the shell as one geom of `body`; masses are the link's own, so it has none."""
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE if self.rounded else mujoco.mjtGeom.mjGEOM_CYLINDER,
            fromto=[*self.start, *self.end],
            size=[self.radius, 0.0, 0.0],
            rgba=self.rgba,
            density=0.0,
            contype=int(self.solid),
            conaffinity=int(self.solid),
            group=0,
        )


def _can(center: Point, axis: int, half: float, radius: float, lids: tuple[int, ...] = ()) -> tuple[Shell, ...]:
    """A joint housing along `axis`, with a blue lid at each end named in `lids` (−1, 1)."""

    def along(distance: float) -> Point:
        x, y, z = (c + (distance if k == axis else 0.0) for k, c in enumerate(center))
        return x, y, z

    housing = Shell(along(-half), along(half), radius, solid=True)
    covers = tuple(Shell(along(side * half), along(side * (half + 0.012)), 0.92 * radius, LID_BLUE) for side in lids)
    return (housing, *covers)


def _tube(start: Point, end: Point, radius: float) -> tuple[Shell, ...]:
    """A tube with a dark ring at each end."""
    rings = tuple(
        Shell((x, y, z - 0.012), (x, y, z + 0.012), 1.06 * radius, JOINT_GREY)
        for x, y, z in ((start[0], start[1], start[2] + 0.09), (end[0], end[1], end[2] - 0.08))
    )
    return (Shell(start, end, radius, solid=True), *rings)


def arm_shells() -> dict[str, tuple[Shell, ...]]:
    """The shells of every link of the UR10, from its DH lengths and the radii of its data sheet's drawings."""
    return {
        "base": (
            Shell((0, 0, 0), (0, 0, 0.012), 0.095, JOINT_GREY),
            Shell((0, 0, 0.012), (0, 0, 0.045), 0.090, solid=True),
        ),
        "shoulder": (
            Shell((0, 0, -0.082), (0, 0, 0.02), 0.088, solid=True),
            *_can((0, 0.04, 0), 1, 0.085, 0.088, lids=(-1,)),
        ),
        "upper_arm": (
            *_can((0, -0.02, 0), 1, 0.075, 0.088, lids=(1,)),
            *_tube((0, -0.02, 0), (0, -0.02, 0.612), 0.065),
            *_can((0, -0.02, 0.612), 1, 0.072, 0.072, lids=(1,)),
        ),
        "forearm": (
            *_can((0, 0.010, 0), 1, 0.062, 0.068, lids=(-1,)),
            *_tube((0, 0, 0), (0, 0, 0.5723), 0.050),
            *_can((0, 0, 0.5723), 1, 0.052, 0.054, lids=(-1,)),
        ),
        "wrist_1": (
            *_can((0, 0.098, 0), 1, 0.046, 0.050, lids=(1,)),
            Shell((0, 0.1149, -0.045), (0, 0.1149, 0.055), 0.047, solid=True),
        ),
        "wrist_2": (
            *_can((0, 0, 0.095), 2, 0.046, 0.050, lids=(1,)),
            Shell((0, -0.045, 0.1157), (0, 0.045, 0.1157), 0.047, solid=True),
        ),
        "wrist_3": (Shell((0, 0.050, 0), (0, 0.0922, 0), 0.045, JOINT_GREY, solid=True),),
    }


def mesh_shells(spec: mujoco.MjSpec) -> dict[str, tuple[Shell, ...]]:
    """The maker's shells; needs the extra `graspcell[meshes]`."""
    raise NotImplementedError
