"""Parts made in code, as an engineer's CAD would export them: millimetres, as meshes that files can hold."""

from collections.abc import Callable

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold

SEGMENTS = 48  # of every circle


def bracket() -> Manifold:
    """An angle of 90 × 60 × 50 mm, 8 mm thick, with two holes in each leg; its corner is rounded by a web."""
    foot, wall = Manifold.cube((90, 60, 8)), Manifold.cube((8, 60, 50))
    web = Manifold.extrude(CrossSection([[(0, 0), (30, 0), (0, 30)]]), 8).rotate((90, 0, 0)).translate((8, 34, 8))
    solid = foot + wall + web
    for y in (15, 45):
        solid -= Manifold.cylinder(20, 5.5, circular_segments=SEGMENTS).translate((68, y, -5))
        solid -= Manifold.cylinder(20, 5.5, circular_segments=SEGMENTS).rotate((0, 90, 0)).translate((-5, y, 36))
    return solid


def cup() -> Manifold:
    """A cup, 70 mm high, 64 mm wide at its rim, with walls of 3 mm and a bottom of 4 mm."""
    outer = Manifold.cylinder(70, 26, 32, circular_segments=SEGMENTS)
    return outer - Manifold.cylinder(70, 23, 29, circular_segments=SEGMENTS).translate((0, 0, 4))


def gear() -> Manifold:
    """A spur gear of 20 teeth, 84 mm wide and 16 mm thick, with a hub of 30 mm and a bore of 12 mm."""
    teeth, outline = 20, []
    for tooth in range(teeth):
        for share, radius in ((0.0, 36.0), (0.22, 36.0), (0.36, 42.0), (0.58, 42.0), (0.72, 36.0)):
            angle = 2 * np.pi * (tooth + share) / teeth
            outline.append((radius * np.cos(angle), radius * np.sin(angle)))
    wheel = Manifold.extrude(CrossSection([outline]), 16)
    hub = Manifold.cylinder(26, 15, circular_segments=SEGMENTS)
    return wheel + hub - Manifold.cylinder(60, 6, circular_segments=SEGMENTS).translate((0, 0, -10))


def elbow() -> Manifold:
    """A pipe elbow of 90°, 32 mm wide outside and 24 mm inside, with collars of 40 mm at its ends."""

    def bend(radius: float) -> Manifold:
        return Manifold.revolve(
            CrossSection.circle(radius, SEGMENTS).translate((45, 0)), circular_segments=SEGMENTS, revolve_degrees=90
        )

    def pipe(radius: float, length: float, start: float = 0.0) -> Manifold:
        first = Manifold.cylinder(length, radius, circular_segments=SEGMENTS).rotate((90, 0, 0))
        second = Manifold.cylinder(length, radius, circular_segments=SEGMENTS).rotate((0, -90, 0))
        return first.translate((45, -start, 0)) + second.translate((-start, 45, 0))

    solid = bend(16) + pipe(16, 15) + pipe(20, 8, 12)
    return solid - bend(12) - pipe(12, 30, -0.5)


def clip() -> Manifold:
    """A spring clip bent from a strip of 18 × 2 mm: 80 mm long, open on one side."""
    outline = [(0, 0), (80, 0), (80, 2), (2, 2), (2, 20), (60, 20), (72, 26), (71, 28), (60, 22), (0, 22)]
    return Manifold.extrude(CrossSection([outline]), 18)


SHAPES: dict[str, Callable[[], Manifold]] = {
    "bracket": bracket,
    "cup": cup,
    "gear": gear,
    "elbow": elbow,
    "clip": clip,
}


def shape(name: str) -> trimesh.Trimesh:
    """The shape of this name, in millimetres."""
    mesh = SHAPES[name]().to_mesh()
    return trimesh.Trimesh(np.asarray(mesh.vert_properties)[:, :3].astype(float), np.asarray(mesh.tri_verts))
