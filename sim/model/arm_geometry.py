"""What the UR10 collides with, and hides parts with: cans, tubes and lids."""

from dataclasses import dataclass

import mujoco

Color = tuple[float, float, float, float]

ALUMINIUM = (0.65, 0.65, 0.65, 1.0)
LID_BLUE = (0.39, 0.54, 0.64, 1.0)
JOINT_GREY = (0.22, 0.22, 0.22, 1.0)

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Shell:
    """A cylinder from `start` to `end` in the link's frame, metres; `solid` ones collide."""

    start: Point
    end: Point
    radius: float
    rgba: Color
    solid: bool = False

    def add_to(self, body: mujoco.MjsBody) -> None:
        """Adds the shell as one geom of `body`; masses are the link's own, so it has none."""
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            fromto=[*self.start, *self.end],
            size=[self.radius, 0.0, 0.0],
            rgba=self.rgba,
            density=0.0,
            contype=int(self.solid),
            conaffinity=int(self.solid),
        )


def _cylinder(center: Point, axis: int, ends: tuple[float, float], radius: float, rgba: Color) -> Shell:
    """A solid cylinder along coordinate `axis` of the line through `center`, between two values of that coordinate."""
    start, end = list(center), list(center)
    start[axis], end[axis] = ends
    return Shell((start[0], start[1], start[2]), (end[0], end[1], end[2]), radius, rgba, solid=True)


def _joint(center: Point, axis: int, ends: tuple[float, float, float], radius: float) -> tuple[Shell, ...]:
    """A motor's housing and its blue lid: the housing from ends[0] to ends[1], the lid on to ends[2]."""
    housing, seam, lid = ends
    return (
        _cylinder(center, axis, (housing, seam), radius, JOINT_GREY),
        _cylinder(center, axis, (seam, lid), 0.97 * radius, LID_BLUE),
    )


def arm_shells() -> dict[str, tuple[Shell, ...]]:
    """The shells of every link of the UR10: its DH lengths, with the radii and ends of its maker's meshes."""
    return {
        "base": (
            Shell((0, 0, 0), (0, 0, 0.010), 0.095, JOINT_GREY),
            Shell((0, 0, 0.010), (0, 0, 0.038), 0.075, ALUMINIUM, solid=True),
        ),
        "shoulder": (
            *_joint((0, 0, 0), 2, (-0.089, 0.030, 0.088), 0.075),
            _cylinder((0, 0, 0), 1, (0.0, 0.086), 0.070, JOINT_GREY),
        ),
        "upper_arm": (
            *_joint((0, 0, 0), 1, (-0.134, -0.018, 0.042), 0.075),
            Shell((0, -0.045, 0), (0, -0.045, 0.612), 0.056, ALUMINIUM, solid=True),
            *_joint((0, 0, 0.612), 1, (-0.110, -0.036, 0.024), 0.060),
        ),
        "forearm": (
            *_joint((0, 0, 0), 1, (0.061, -0.009, -0.069), 0.060),
            Shell((0, 0, 0), (0, 0, 0.5723), 0.045, ALUMINIUM, solid=True),
            *_joint((0, 0, 0.5723), 1, (0.060, -0.011, -0.058), 0.046),
        ),
        "wrist_1": (
            _cylinder((0, 0, 0), 1, (0.062, 0.115), 0.045, JOINT_GREY),
            *_joint((0, 0.1149, 0), 2, (0.061, -0.010, -0.057), 0.045),
        ),
        "wrist_2": (
            _cylinder((0, 0, 0), 2, (0.063, 0.115), 0.045, JOINT_GREY),
            *_joint((0, 0, 0.1157), 1, (0.061, -0.010, -0.057), 0.045),
        ),
        "wrist_3": (Shell((0, 0.062, 0), (0, 0.0922, 0), 0.045, ALUMINIUM, solid=True),),
    }
