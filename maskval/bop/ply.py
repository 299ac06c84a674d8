"""The vertices and triangles of a PLY file, text or binary; colours, normals and textures are passed over."""

from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.bop.fields import is_whole, numbers_of
from maskval.errors import InvalidFileError
from maskval.inputs.files import MOST_MESH, read_input

TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
INDEX_NAMES = ("vertex_indices", "vertex_index")


class _Property(NamedTuple):
    name: str
    kind: str
    counted_by: str | None  # the type of a list's length


class _Element(NamedTuple):
    name: str
    rows: int
    properties: list[_Property]


def read_ply(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The vertices, (V, 3), in the file's unit, and the triangles, (F, 3).

    Args:
        path: The file, whose faces are all triangles.

    Raises:
        InvalidFileError: If the file is malformed; the message says the line, or the byte of a binary file.
    """
    content = read_input(path, MOST_MESH)
    order, elements, start, line = _header(path, content)
    if order:
        tables = _binary_tables(path, content, start, elements, order)
    else:
        tables = _text_tables(path, content[start:], line, elements)
    for name in ("vertex", "face"):
        if name not in tables:
            raise InvalidFileError(f"{path}: expected an element {name!r}, but found {sorted(tables)}")
    vertex, face = tables["vertex"], tables["face"]
    missing = [axis for axis in "xyz" if axis not in vertex]
    indices = next((face[name] for name in INDEX_NAMES if name in face), None)
    if missing or indices is None:
        raise InvalidFileError(f"{path}: expected x, y, z and vertex_indices, but found {[*vertex, *face]}")
    if not ((np.abs(indices.astype(np.float64)) < 2**31) & (indices == np.floor(indices))).all():
        raise InvalidFileError(f"{path}: expected whole numbers below 2^31 as vertex_indices")
    return np.stack([vertex[axis] for axis in "xyz"], axis=1).astype(np.float64), indices.astype(np.int64)


def write_ply(path: Path, vertices: NDArray[np.float64], faces: NDArray[Any]) -> None:
    """Writes vertices, (V, 3), and triangles, (F, 3), as text."""
    lines = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
        *(" ".join(repr(float(value)) for value in vertex) for vertex in vertices),
        *(f"3 {a} {b} {c}" for a, b, c in faces),
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def _header(path: Path, content: bytes) -> tuple[str, list[_Element], int, int]:
    """The byte order ('' for text), the elements, where the data begins, and on which line."""
    end = content.find(b"end_header")
    if not content.startswith(b"ply") or end < 0:
        raise InvalidFileError(f"{path}:1:1: expected a PLY file, from 'ply' to 'end_header'")
    start = content.find(b"\n", end) + 1 or len(content)
    order = None
    elements: list[_Element] = []
    lines = content[:end].decode("ascii", errors="replace").splitlines()
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        match words:
            case ["format", name, _] if name in ORDERS:
                order = ORDERS[name]
            case ["element", name, count] if is_whole(count) and name not in {known.name for known in elements}:
                elements.append(_Element(name, int(count), []))
            case ["property", "list", counted_by, kind, name] if {counted_by, kind} <= TYPES.keys() and _new(
                name, elements
            ):
                elements[-1].properties.append(_Property(name, TYPES[kind], TYPES[counted_by]))
            case ["property", kind, name] if kind in TYPES and _new(name, elements):
                elements[-1].properties.append(_Property(name, TYPES[kind], None))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise InvalidFileError(f"{path}:{number}:1: expected a line of a PLY header, but found {line!r}")
    if order is None:
        raise InvalidFileError(f"{path}:2:1: expected a format, one of {sorted(ORDERS)}")
    return order, elements, start, len(lines) + 2


def _new(name: str, elements: list[_Element]) -> bool:
    """Whether the element that the header is at lacks a property."""
    return bool(elements) and name not in {known.name for known in elements[-1].properties}


def _width(path: Path, element: _Element, prop: _Property) -> int:
    """How many values a property has; a list is taken for a triangle's corners, or its texture coordinates."""
    if prop.counted_by is None:
        return 1
    if element.name == "face" and prop.name in (*INDEX_NAMES, "texcoord"):
        return 6 if prop.name == "texcoord" else 3
    raise InvalidFileError(f"{path}: expected no list {prop.name!r} in the element {element.name!r}")


def _binary_tables(
    path: Path, content: bytes, start: int, elements: list[_Element], order: str
) -> dict[str, dict[str, NDArray[Any]]]:
    tables = {}
    for element in elements:
        fields: list[tuple[Any, ...]] = []
        for prop in element.properties:
            width = _width(path, element, prop)
            if prop.counted_by is not None:
                fields.append((f"count of {prop.name}", order + prop.counted_by))
            fields.append((prop.name, order + prop.kind, (width,)) if width > 1 else (prop.name, order + prop.kind))
        kind = np.dtype(fields)
        if element.rows and not fields:
            raise InvalidFileError(f"{path}: expected properties of the {element.rows} {element.name}, but found none")
        stop = start + element.rows * kind.itemsize
        if stop > len(content):
            raise InvalidFileError(
                f"{path}: expected {element.rows} of {element.name} up to byte {stop}, but found {len(content)} bytes"
            )
        rows = np.frombuffer(content, kind, element.rows, start)
        for prop in element.properties:
            if prop.counted_by is not None:
                counts = rows[f"count of {prop.name}"]
                _check_lengths(counts, _width(path, element, prop), lambda index: f"{path}: face {index}")
        tables[element.name] = {prop.name: rows[prop.name] for prop in element.properties}
        start = stop
    return tables


def _text_tables(path: Path, content: bytes, line: int, elements: list[_Element]) -> dict[str, dict[str, NDArray[Any]]]:
    lines = content.decode("ascii", errors="replace").splitlines()
    tables: dict[str, dict[str, NDArray[Any]]] = {}
    done = 0
    for element in elements:
        widths = [_width(path, element, prop) for prop in element.properties]
        listed = [prop.counted_by is not None for prop in element.properties]
        rows = _numbers(path, lines[done : done + element.rows], line + done, element, sum(widths) + sum(listed))
        table: dict[str, NDArray[Any]] = {}
        column = 0
        for prop, width, is_list in zip(element.properties, widths, listed, strict=True):
            if is_list:
                _check_lengths(rows[:, column], width, _line_places(path, line + done))
                column += 1
            table[prop.name] = rows[:, column] if width == 1 else rows[:, column : column + width]
            column += width
        tables[element.name] = table
        done += element.rows
    return tables


def _numbers(path: Path, lines: list[str], line: int, element: _Element, columns: int) -> NDArray[np.float64]:
    """The numbers of an element's lines, (rows, columns).

    What is allocated grows with what is there: the header may promise anything.
    """
    numbers = array("d")
    for index in range(min(element.rows, len(lines) + 1)):
        text = lines[index] if index < len(lines) else ""
        row = numbers_of(text)
        if row is None or len(row) != columns or index == len(lines):
            raise InvalidFileError(
                f"{path}:{line + index}:1: expected {columns} numbers of {element.name} {index}, "
                f"but found {' '.join(text.split())[:40]!r}"
            )
        numbers.extend(row)
    return np.array(numbers).reshape(element.rows, columns)


def _line_places(path: Path, first: int) -> Callable[[int], str]:
    return lambda index: f"{path}:{first + index}:1"


def _check_lengths(lengths: NDArray[Any], expected: int, place: Callable[[int], str]) -> None:
    wrong = np.flatnonzero(lengths != expected)
    if len(wrong):
        index = int(wrong[0])
        raise InvalidFileError(
            f"{place(index)}: expected a list of {expected} (triangles only), but found one of {lengths[index]:g}"
        )
