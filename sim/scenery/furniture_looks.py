"""How belt, container, pedestal and floor look."""

from collections.abc import Iterator

from cell.layout import Belt, Container, Layout
from sim.scenery.robot_looks import Piece
from sim.scenery.solids import Solid, box, rod

_PROFILE = 0.040  # m: side of the aluminium profiles
_FOOT = 0.03  # m from the floor to a profile's end


def furniture_pieces(layout: Layout, slot_size: tuple[float, float]) -> Iterator[Piece]:
    """All of them, in the frames of the bodies that they belong to."""
    height = layout.belt.top_z - layout.floor_z
    for material, solid in _belt(layout.belt, height):
        yield "belt", material, solid
    container = layout.container
    for material, solid in _container(container, slot_size):
        yield "container", material, solid
    for material, solid in _table(container, slot_size, container.floor_z - layout.floor_z):
        yield "container", material, solid
    for material, solid in _pedestal(-layout.floor_z):
        yield "floor", material, solid
    for solid in _marking(layout):
        yield "floor", "tape", solid


def _leg(x: float, y: float, top: float, floor: float) -> Iterator[tuple[str, Solid]]:
    """A profile from `top` down to a foot on the floor, z = `floor`."""
    low = floor + _FOOT
    yield "brushed", box((x, y, (top + low) / 2), (_PROFILE, _PROFILE, top - low), 0.0015)
    for side in (-1, 1):  # the grooves of the profile
        yield "seal", box((x + side * _PROFILE / 2, y, (top + low) / 2), (0.002, 0.008, top - low), 0.0005)
        yield "seal", box((x, y + side * _PROFILE / 2, (top + low) / 2), (0.008, 0.002, top - low), 0.0005)
    yield "steel", rod((x, y, floor + 0.006), (x, y, low), 0.007, 0.001)
    yield "rubber", rod((x, y, floor), (x, y, floor + 0.012), 0.032, 0.0015)


def _belt(belt: Belt, height: float) -> Iterator[tuple[str, Solid]]:
    """Rails, drums, legs with cross beams and the drive; the belt itself is the one that collides."""
    half_x, half_y = belt.width / 2, (belt.length + belt.upstream) / 2
    for side in (-1, 1):
        x = side * (half_x + 0.015)
        yield "brushed", box((x, 0, -0.033), (0.028, 2 * half_y + 0.06, 0.090), 0.004, axis=1)
        for z in (-0.020, -0.055):
            yield "seal", box((x + side * 0.014, 0, z), (0.002, 2 * half_y + 0.05, 0.007), 0.0005, axis=1)
        y = side * half_y
        yield "rubber", rod((-half_x, y, -0.031), (half_x, y, -0.031), 0.029, 0.001)
        for end in (-1, 1):
            yield "steel", rod((end * (half_x + 0.028), y, -0.031), (end * (half_x + 0.034), y, -0.031), 0.018, 0.001)
            yield from _leg(end * half_x, 0.8 * (y + 0.03 * side), -0.078, -height)
        beam = (0, 0.8 * (y + 0.03 * side), -0.62 * height)
        yield "brushed", box(beam, (2 * half_x - _PROFILE, _PROFILE, _PROFILE), 0.0015, axis=0)
    motor_y = -half_y + 0.10
    yield "motor", box((half_x - 0.02, motor_y, -0.125), (0.11, 0.10, 0.10), 0.010)
    yield "motor", rod((half_x - 0.07, motor_y, -0.125), (half_x - 0.24, motor_y, -0.125), 0.045, 0.006)
    for fin in range(7):
        x = half_x - 0.10 - 0.018 * fin
        yield "motor", rod((x, motor_y, -0.125), (x - 0.006, motor_y, -0.125), 0.051, 0.0005)


def _container(container: Container, slot_size: tuple[float, float]) -> Iterator[tuple[str, Solid]]:
    wall, height = container.wall_thickness, container.wall_height
    pitch_x, pitch_y = slot_size[0] + wall, slot_size[1] + wall
    length_x, length_y = container.columns * pitch_x + wall, container.rows * pitch_y + wall
    yield "plastic", box((0, 0, -0.005), (length_x, length_y, 0.010), 0.002, axis=1)
    for column in range(container.columns + 1):
        x = (column - container.columns / 2) * pitch_x
        yield "plastic", box((x, 0, height / 2), (wall, length_y, height), 0.0015, axis=1)
    for row in range(container.rows + 1):
        y = (row - container.rows / 2) * pitch_y
        yield "plastic", box((0, y, height / 2), (length_x, wall, height), 0.0015, axis=0)


def _table(container: Container, slot_size: tuple[float, float], height: float) -> Iterator[tuple[str, Solid]]:
    """A table under the container: its top ends 10 mm below the container's floor."""
    wall = container.wall_thickness
    half_x = (container.columns * (slot_size[0] + wall) + wall) / 2 + 0.01
    half_y = (container.rows * (slot_size[1] + wall) + wall) / 2 + 0.01
    yield "laminate", box((0, 0, -0.025), (2 * half_x, 2 * half_y, 0.028), 0.004, axis=1)
    x, y = half_x - 0.04, half_y - 0.04
    for side in (-1, 1):
        for end in (-1, 1):
            yield from _leg(side * x, end * y, -0.040, -height)
        for z in (-0.060, -0.8 * height):
            yield "brushed", box((side * x, 0, z), (_PROFILE, 2 * y - _PROFILE, _PROFILE), 0.0015, axis=1)
            yield "brushed", box((0, side * y, z), (2 * x - _PROFILE, _PROFILE, _PROFILE), 0.0015, axis=0)
    yield "laminate", box((0, 0, -0.8 * height + 0.03), (2 * x, 2 * y, 0.018), 0.003, axis=1)


def _pedestal(height: float) -> Iterator[tuple[str, Solid]]:
    """A painted column between two steel plates, with its bolts."""
    yield "paint", box((0, 0, height / 2), (0.22, 0.22, height - 0.03), 0.015)
    yield "steel", box((0, 0, 0.008), (0.40, 0.40, 0.016), 0.004)
    yield "steel", box((0, 0, height - 0.010), (0.26, 0.26, 0.020), 0.004)
    for x in (-0.165, 0.165):
        for y in (-0.165, 0.165):
            yield "anodised", rod((x, y, 0.016), (x, y, 0.028), 0.013, 0.002)


def _marking(layout: Layout) -> Iterator[Solid]:
    """Tape on the floor around the cell."""
    low_x, high_x, wide = -0.55, layout.belt.center_x + 0.68, 0.05
    low_y, high_y = -1.45, layout.belt.length / 2 + layout.belt.upstream + 0.35
    middle = ((low_x + high_x) / 2, (low_y + high_y) / 2)
    for x in (low_x, high_x):
        yield box((x, middle[1], 0.0005), (wide, high_y - low_y + wide, 0.001), 0.0004, axis=1)
    for y in (low_y, high_y):
        yield box((middle[0], y, 0.0005), (high_x - low_x - wide, wide, 0.001), 0.0004, axis=0)
