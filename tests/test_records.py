"""All records of all packages are frozen, compare by identity where they hold arrays, and keep these read-only."""

import dataclasses
import importlib
import pkgutil
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import maskval
from cell.arm.trajectory import JointTrajectory
from cell.interfaces import Detection, Frame
from maskval import Camera, Correspondences, Estimates, ImageErrors, Mesh, PackedMasks, Pose, SymmetryAxis, bop
from maskval.evaluation.matching import Evaluation
from maskval.evaluation.metrics import RecallCurve, sweep
from tests.maskval import shapes

PACKAGES = ("maskval", "cell", "sim", "policies", "experiments")
# They gather what comes in, and say so.
GROWING = {
    "Annotations",
    "Motion",
    "Observer",
    "Plot",
    "Recorder",
    "RunFolder",
    "Source",
    "Take",
    "_Cameras",
    "_Progress",
    "_Seen",
}


NEED_TORCH = "experiments.training.networks."  # which is not among what tests need


def records_of(package: str) -> list[type[Any]]:
    """The dataclasses that the modules of a package define."""
    path = importlib.import_module(package).__path__
    names = [found.name for found in pkgutil.walk_packages(path, f"{package}.")]
    modules = [importlib.import_module(name) for name in names if not name.startswith(NEED_TORCH)]
    return [
        each
        for module in modules
        for each in vars(module).values()
        if isinstance(each, type) and dataclasses.is_dataclass(each) and each.__module__ == module.__name__
    ]


def array_fields(record: type[Any]) -> list[str]:
    return [field.name for field in dataclasses.fields(record) if "ndarray" in str(field.type)]


RECORDS = [record for package in PACKAGES for record in records_of(package)]


def parameters(record: type[Any]) -> Any:
    return record.__dataclass_params__


def test_every_record_is_frozen_but_the_few_that_gather() -> None:
    assert len(RECORDS) >= 140
    assert {record.__name__ for record in RECORDS if not parameters(record).frozen} == GROWING


def test_no_record_that_holds_arrays_compares_them() -> None:
    holders = [record for record in RECORDS if array_fields(record)]
    assert len(holders) >= 35
    # `==` of arrays is an array, which is neither true nor false.
    assert [record for record in holders if parameters(record).eq] == []


TURN, PLACE = np.eye(3), np.array([0.0, 0.0, 0.5])
CORNERS, FACES = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]), np.array([[0, 1, 2]])
WORDS = np.zeros((1, 4, 1), dtype=np.uint64)
SCORES, MASKS, DEPTH = np.ones(1), np.ones((1, 4, 4), dtype=bool), np.ones((4, 4), dtype=np.float32)
TABLE, U, VISIBLE = np.zeros((1, 1)), np.zeros(1), np.ones(1)
INDEX = np.zeros(1, dtype=np.int64)
ERRORS, SIGMAS = np.array([0.01, 0.02]), np.ones(3)
WAY, RATES = np.zeros((2, 6)), np.ones((2, 6))
RGB = np.zeros((4, 4, 3), dtype=np.uint8)
SMALL = Camera(4, 4, 2, 2, 4, 4)
AHEAD = Pose(TURN, PLACE)
EVALUATION = Evaluation(1, INDEX, INDEX, U, U, INDEX, VISIBLE)

# A record of each kind, and the arrays that it was made of, if they came from outside.
MADE: dict[type[Any], tuple[Callable[[], Any], tuple[np.ndarray, ...]]] = {
    Pose: (lambda: Pose(TURN, PLACE), (TURN, PLACE)),
    SymmetryAxis: (lambda: SymmetryAxis(PLACE, PLACE), (PLACE,)),
    Mesh: (lambda: Mesh(CORNERS, FACES), (CORNERS, FACES)),
    Correspondences: (lambda: Correspondences(CORNERS, CORNERS[:, :2], SIGMAS), (CORNERS, SIGMAS)),
    PackedMasks: (lambda: PackedMasks(WORDS, 4), (WORDS,)),
    Estimates: (
        lambda: Estimates(SMALL, shapes.square(), MASKS, ((AHEAD,),), SCORES, depth=DEPTH, rgb=RGB.copy()),
        (MASKS, SCORES, DEPTH),
    ),
    ImageErrors: (lambda: ImageErrors(TABLE, U, VISIBLE), (TABLE, U, VISIBLE)),
    Evaluation: (lambda: EVALUATION, (INDEX, U, VISIBLE)),
    bop.ImageCamera: (lambda: bop.ImageCamera(TURN), (TURN,)),
    RecallCurve: (lambda: RecallCurve(ERRORS, (0.0, 0.0), ERRORS, ERRORS, ERRORS), (ERRORS,)),
    maskval.Silhouette: (lambda: maskval.silhouette(shapes.square(), AHEAD, SMALL), ()),
    maskval.DepthCrop: (lambda: maskval.depth_crop(shapes.square(), AHEAD, SMALL), ()),
    maskval.Uncertainties: (lambda: maskval.uncertainty(shapes.square(), [AHEAD], MASKS, SMALL), ()),
    type(sweep(EVALUATION, 0.01)): (lambda: sweep(EVALUATION, 0.01), ()),
    Detection: (lambda: Detection(MASKS[0], 1.0), (MASKS,)),
    JointTrajectory: (lambda: JointTrajectory(0.1, WAY, RATES), (WAY, RATES)),
    Frame: (lambda: Frame(0, 0.0, SMALL, AHEAD, RGB.copy(), DEPTH.copy()), ()),
}


def test_every_record_of_the_library_that_holds_arrays_is_looked_at() -> None:
    holders = {record for record in RECORDS if record.__module__.startswith("maskval.") and array_fields(record)}
    assert len(holders) >= 13
    assert holders <= MADE.keys()


@pytest.mark.parametrize("record", MADE, ids=lambda record: record.__name__)
def test_nobody_can_write_to_the_arrays_of_a_record(record: type[Any]) -> None:
    make, given = MADE[record]
    made, names = make(), array_fields(record)
    assert type(made) is record
    assert len(names) >= 1
    for name in names:
        held = getattr(made, name)
        assert held.size > 0
        with pytest.raises(ValueError, match="read-only"):
            held[...] = 0
        # What it was made of stays its maker's: writeable, and another array.
        assert not any(np.shares_memory(held, array) for array in given)
    assert all(array.flags.writeable for array in given)
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(made, names[0], None)
