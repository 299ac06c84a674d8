"""Wrong arguments of the library are MaskvalErrors; homogeneous matrices will do wherever poses do."""

import importlib.metadata
import math
from collections.abc import Callable

import numpy as np
import pytest

import maskval
from maskval import (
    Camera,
    ContourDistance,
    Counting,
    Estimates,
    Evaluation,
    ImageErrors,
    MaskVal,
    MaskvalError,
    Mesh,
    PackedMasks,
    Pose,
    SymmetryAxis,
    add,
    add_s,
    associate,
    aurc,
    auroc,
    bootstrap_interval,
    bootstrap_mean_interval,
    bop,
    certified_threshold,
    conformal_threshold,
    depth_crop,
    depth_image,
    mask_from_rle,
    mask_iou,
    maskval_uncertainty,
    match_images,
    mdd,
    mean_interval,
    mspd,
    mssd,
    paper_threshold,
    proportion_interval,
    rates,
    recall_curve,
    rotation_error,
    silhouette,
    silhouette_boxes,
    silhouette_iou,
    spearman,
    summarise,
    symmetry_poses,
    translation_error,
    uncertainty,
    vsd,
)
from maskval.rendering.silhouettes import silhouette_areas
from maskval.statistics.cluster_intervals import clustered_rate_interval
from tests.maskval import shapes

CUBE = shapes.cube(0.08)
CAMERA = Camera(60.0, 60.0, 32.0, 24.0, 64, 48)
X = Pose.from_rotvec((0.2, 0.3, 0.4), (0.0, 0.02, 0.6))
Y = Pose.from_rotvec((0.2, 0.3, 0.5), (0.01, 0.02, 0.6))
MASK = silhouette(CUBE, X, CAMERA).mask
POINTS = CUBE.vertices
FOUND = match_images([ImageErrors([[0.01], [0.02]], [0.1, 0.2], [1.0])])
NAN, RNG = math.nan, np.random.default_rng(0)


def same(one: object, other: object) -> None:
    """Asserts that both are equal, whatever they are made of."""
    if isinstance(one, tuple) and not isinstance(other, np.ndarray):
        for a, b in zip(one, other, strict=True):
            same(a, b)
    elif isinstance(one, Pose):
        np.testing.assert_array_equal(one.matrix, other.matrix)
    elif isinstance(one, float | np.ndarray):
        np.testing.assert_array_equal(one, other)
    else:
        names = getattr(one, "__slots__", None) or vars(one)
        assert names
        for name in names:
            same(np.asarray(getattr(one, name)), np.asarray(getattr(other, name)))


SINGLE: dict[str, Callable[[object], object]] = {
    "silhouette": lambda P: silhouette(CUBE, P, CAMERA),
    "depth_image": lambda P: depth_image(CUBE, P, CAMERA),
    "depth_crop": lambda P: depth_crop(CUBE, P, CAMERA),
    "mdd": lambda P: mdd(P, Y, POINTS),
    "mdd of a true one": lambda P: mdd(Y, P, POINTS),
    "add": lambda P: add(P, Y, POINTS),
    "add_s": lambda P: add_s(Y, P, POINTS),
    "mssd": lambda P: mssd(P, Y, POINTS, [Pose.identity()]),
    "mssd of a true one": lambda P: mssd(Y, P, POINTS, [Pose.identity()]),
    "mspd": lambda P: mspd(P, P, POINTS, [Pose.identity()], CAMERA),
    "rotation_error": lambda P: rotation_error(P, Y),
    "translation_error": lambda P: translation_error(Y, P),
    "vsd": lambda P: vsd(CUBE, P, Y, np.zeros((48, 64)), CAMERA, taus_m=[0.01]),
    "PoseResult": lambda P: bop.PoseResult(1, 2, 3, 0.5, P).X_CO,
    "GroundTruth": lambda P: bop.GroundTruth(1, P).X_CO,
    "ImageCamera": lambda P: bop.ImageCamera(CAMERA.K, X_CW=P).X_CW,
    "Estimates": lambda P: Estimates(CAMERA, CUBE, MASK[None], ((X,),), np.ones(1), X_BC=P).X_BC,
}
MANY: dict[str, Callable[[object], object]] = {
    "uncertainty": lambda P: uncertainty(CUBE, P, np.array([MASK, MASK]), CAMERA),
    "silhouette_iou": lambda P: silhouette_iou(CUBE, P, MASK[None], CAMERA),
    "silhouette_areas": lambda P: silhouette_areas(CUBE, P, CAMERA),
    "silhouette_boxes": lambda P: silhouette_boxes(CUBE, P, CAMERA, inside_image=True),
    "symmetry_poses": symmetry_poses,
    "mssd's symmetries": lambda P: mssd(X, Y, POINTS, P),
    "mspd's symmetries": lambda P: mspd(X, Y, POINTS, P, CAMERA),
    "ModelInfo": lambda P: bop.ModelInfo(0.1, P).symmetries,
    "Estimates": lambda P: MaskVal()(Estimates(CAMERA, CUBE, np.array([MASK, MASK]), (P,), np.ones(2))),
    "contour": lambda P: ContourDistance()(Estimates(CAMERA, CUBE, np.array([MASK, MASK]), (P,), np.ones(2))),
}


@pytest.mark.parametrize("name", SINGLE)
def test_a_matrix_will_do_for_a_pose(name: str) -> None:
    made = SINGLE[name](X)
    same(made, SINGLE[name](X.matrix))
    same(made, SINGLE[name](X.matrix.tolist()))


@pytest.mark.parametrize("name", MANY)
def test_an_array_of_matrices_or_a_mixed_list_will_do_for_poses(name: str) -> None:
    made = MANY[name]((X, Y))
    for given in (np.array([X.matrix, Y.matrix]), [X, Y.matrix], [X.matrix, Y.matrix], (X.matrix, Y)):
        same(made, MANY[name](given))


def test_estimates_take_the_poses_of_all_estimators_in_one_array() -> None:
    made = Estimates(CAMERA, CUBE, MASK[None], np.array([[X.matrix], [Y.matrix]]), np.ones(1))
    assert [len(poses) for poses in made.poses] == [1, 1]
    same(made.poses[1][0], Y)


def test_no_poses_are_an_empty_array_too() -> None:
    found = uncertainty(CUBE, np.empty((0, 4, 4)), np.empty((0, 48, 64), dtype=bool), CAMERA)
    assert len(found.u) == 0


def test_the_package_says_its_version() -> None:
    assert maskval.__version__ == importlib.metadata.version("graspcell")
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = maskval.nothing


def scaled(factor: float) -> np.ndarray:
    matrix = X.matrix.copy()
    matrix[:3, :3] *= factor
    return matrix


WRONG: list[tuple[str, Callable[[], object], str]] = [
    ("a pose of text", lambda: Pose("x", (0, 0, 0)), "rotation must be real numbers"),
    ("text digits", lambda: Pose(np.eye(3), ("0", "0", "1")), "translation must be real numbers"),
    ("nothing", lambda: Pose(None, (0, 0, 0)), "rotation must be real numbers"),
    ("complex", lambda: Pose(np.eye(3) * 1j, (0, 0, 0)), "rotation must be real numbers"),
    ("ragged", lambda: Pose([[1, 0], [0]], (0, 0, 0)), "rotation must be real numbers"),
    ("scaled", lambda: silhouette(CUBE, scaled(1000), CAMERA), "rotation must be orthonormal"),
    ("transposed", lambda: silhouette(CUBE, X.matrix.T, CAMERA), "last row of a homogeneous matrix must be 0 0 0 1"),
    ("3 x 4", lambda: silhouette(CUBE, X.matrix[:3], CAMERA), r"matrix must have shape \(4, 4\)"),
    ("one for many", lambda: silhouette_iou(CUBE, X, MASK[None], CAMERA), "poses must be a list of poses or an array"),
    ("a matrix for many", lambda: silhouette_iou(CUBE, X.matrix, MASK[None], CAMERA), "pose 0: matrix must have shape"),
    ("a number for many", lambda: silhouette_boxes(CUBE, 3, CAMERA), "poses must be a list of poses"),
    ("one of two", lambda: uncertainty(CUBE, [X, scaled(2)], np.array([MASK] * 2), CAMERA), "pose 1: rotation must be"),
    ("points of text", lambda: X.apply("abc"), "points_B must be real numbers"),
    ("points", lambda: mdd(X, Y, [[0, "a", 0]]), "points_O must be real numbers"),
    ("K", lambda: Camera.from_K("K", 4, 4), "K must be real numbers"),
    ("focal length", lambda: Camera("600", 600, 0, 0, 4, 4), "fx must be a number, but is '600'"),
    ("width", lambda: Camera(600, 600, 0, 0, None, 4), "width must be a number, but is None"),
    ("project", lambda: CAMERA.project([[1, 2], [3]]), "points_C must be real numbers"),
    ("vertices", lambda: Mesh([["a", 0, 0]], [[0, 0, 0]]), "vertices must be real numbers"),
    ("faces", lambda: Mesh(POINTS, [[0, 1, 2], [0]]), "faces must be triangles"),
    ("masks", lambda: PackedMasks.pack([[[True]], [[True, False]]]), "masks must be of one size"),
    ("two masks", lambda: mask_iou(MASK, MASK[:1]), "masks must have one size"),
    ("implementation", lambda: silhouette(CUBE, X, CAMERA, implementation="gpu"), "implementation must be one of"),
    ("depth's", lambda: depth_image(CUBE, X, CAMERA, implementation="gpu"), "implementation must be one of"),
    ("packing's", lambda: PackedMasks.pack(MASK, implementation="gpu"), "implementation must be one of"),
    ("pixel centre 1", lambda: silhouette(CUBE, X, CAMERA, pixel_center=1), r"pixel_center must be in \[0, 1\)"),
    ("pixel centre nan", lambda: silhouette(CUBE, X, CAMERA, pixel_center=NAN), "pixel_center must be in"),
    ("pixel centre text", lambda: silhouette(CUBE, X, CAMERA, pixel_center="0.5"), "pixel_center must be in"),
    ("canvas", lambda: silhouette(CUBE, X, CAMERA, canvas="2x2"), "canvas must be 'full' or '3x3'"),
    ("alpha", lambda: MaskVal(alpha=None), r"alpha must be in \[0, 1\], but is None"),
    ("alpha nan", lambda: maskval_uncertainty(0.5, 0.5, NAN), "alpha must be in"),
    ("alpha true", lambda: MaskVal(alpha=True), "alpha must be in"),
    ("iou", lambda: maskval_uncertainty("a", 0.5), "iou must be real numbers"),
    ("visibility", lambda: maskval_uncertainty(0.5, 1.5), r"visibility must be in \[0, 1\]"),
    ("association", lambda: uncertainty(CUBE, [X], MASK[None], CAMERA, association="best"), "association must be"),
    ("iou table", lambda: associate([["a"]], "greedy"), "iou must be real numbers"),
    ("run lengths", lambda: mask_from_rle([-1, 2], 1, 1), "counts must be whole numbers >= 0"),
    ("image without pixels", lambda: mask_from_rle([], 0, 0), "a mask must have 1 to"),
    ("u_T nan", lambda: rates(FOUND, 0.015, NAN), "u_T must be a number, but is nan"),
    ("u_T text", lambda: rates(FOUND, 0.015, "0.5"), "u_T must be a number"),
    ("u_T complex", lambda: rates(FOUND, 0.015, 1j), "u_T must be a number"),
    ("e_t nan", lambda: rates(FOUND, NAN), "e_t must be >= 0, but is nan"),
    ("e_t below 0", lambda: rates(FOUND, -1.0), "e_t must be >= 0, but is -1"),
    ("e_t text", lambda: paper_threshold(FOUND, "15 mm"), "e_t must be >= 0"),
    ("AP 0", lambda: paper_threshold(FOUND, 0.015, 0.0), r"demanded_ap must be in \(0, 1\]"),
    ("AP text", lambda: recall_curve(FOUND, [0, 0.01], "0.99"), "demanded_ap must be in"),
    ("curve nan", lambda: recall_curve(FOUND, [0, NAN]), "at least two rising thresholds"),
    ("curve text", lambda: recall_curve(FOUND, ["a", "b"]), "errors_m must be real numbers"),
    ("level 1", lambda: summarise(FOUND, level=1.0, resamples=1), r"level must be in \(0, 1\)"),
    ("no resamples", lambda: summarise(FOUND, resamples=0), "a summary needs images and resamples"),
    ("e_t of a summary", lambda: summarise(FOUND, NAN, resamples=1), "e_t must be >= 0"),
    ("confidence", lambda: certified_threshold([0.1], [False], confidence=1), r"confidence must be in \(0, 1\)"),
    ("risk", lambda: conformal_threshold([0.1], [False], maximum_risk=NAN), r"maximum_risk must be in \(0, 1\)"),
    ("grid", lambda: certified_threshold([0.1], [False], grid=["a"]), "grid must be real numbers"),
    ("u of text", lambda: conformal_threshold(["a"], [False]), "u must be real numbers"),
    ("half an image", lambda: Evaluation(1, [0.5], [0], [0.1], [0.1], [0], [1.0]), "pose_image must be whole numbers"),
    ("images of text", lambda: Evaluation("1", [0], [0], [0.1], [0.1], [0], [1.0]), "images must be >= 0"),
    ("u nan", lambda: Evaluation(1, [0], [0], [0.1], [NAN], [0], [1.0]), "u must be finite"),
    ("errors of text", lambda: ImageErrors([["a"]], [0.1], [1.0]), "errors_m must be real numbers"),
    ("ragged errors", lambda: ImageErrors([[1, 2], [1]], [0.1, 0.2], [1.0]), "errors_m must be real numbers"),
    (
        "negative errors",
        lambda: match_images([ImageErrors([[-1.0]], [0.1], [1.0])]),
        "errors_m of image 0 must be",
    ),
    ("counting", lambda: Counting(visibility_threshold=NAN), r"visibility_threshold must be in \[0, 1\]"),
    ("spearman", lambda: spearman(["a"], [1]), "both must be real numbers"),
    ("auroc", lambda: auroc([0.1], [1, 0]), r"both must have one shape \(N,\)"),
    ("aurc", lambda: aurc([NAN], [1]), "must be finite"),
    (
        "bootstrap",
        lambda: bootstrap_interval(FOUND, lambda _: 1.0, np.random.default_rng(0), resamples=0),
        "a bootstrap",
    ),
    ("successes", lambda: proportion_interval(3, 2), r"successes must be in \[0, 2\]"),
    ("trials nan", lambda: proportion_interval(0, NAN), "trials must be >= 0"),
    ("level text", lambda: proportion_interval(1, 2, "0.95"), r"level must be in \(0, 1\)"),
    ("a mean", lambda: mean_interval(["a", "b"]), "values must be real numbers"),
    ("a mean of nan", lambda: mean_interval([NAN]), "values must be finite"),
    (
        "a mean's samples",
        lambda: bootstrap_mean_interval([1], np.random.default_rng(0), resamples=0),
        "resamples must be",
    ),
    ("clusters", lambda: clustered_rate_interval([2.0], [1], [0]), "expected rates in 0..1"),
    ("clusters' level", lambda: clustered_rate_interval([0.5], [1], [0], 0.0), r"level must be in \(0, 1\)"),
    ("axis", lambda: SymmetryAxis("z", (0, 0, 0)), "axis_O must be real numbers"),
    ("step", lambda: symmetry_poses(maximum_step=1e-12), "maximum_step must be in"),
    ("no symmetries", lambda: mssd(X, Y, POINTS, []), "symmetries must hold at least the identity"),
    ("taus", lambda: vsd(CUBE, X, Y, np.zeros((48, 64)), CAMERA, taus_m=["a"]), "taus_m must be real numbers"),
    ("delta", lambda: vsd(CUBE, X, Y, np.zeros((48, 64)), CAMERA, taus_m=[1], delta_m=NAN), "delta_m must be >= 0"),
    ("scores", lambda: Estimates(CAMERA, CUBE, MASK[None], ((X,),), ["a"]), "scores must be real numbers"),
    ("no estimators", lambda: Estimates(CAMERA, CUBE, MASK[None], (), [1.0]), "poses must hold those of at least one"),
    ("X_BC", lambda: Estimates(CAMERA, CUBE, MASK[None], ((X,),), [1.0], X_BC=3), "matrix must have shape"),
    ("a result's pose", lambda: bop.PoseResult(1, 2, 3, 0.5, "X"), "matrix must be real numbers"),
    ("an image's K", lambda: bop.ImageCamera("K"), "K must be real numbers"),
]


@pytest.mark.parametrize(("call", "words"), [row[1:] for row in WRONG], ids=[row[0] for row in WRONG])
def test_a_wrong_argument_is_a_maskval_error_that_says_what_is_valid(call: Callable[[], object], words: str) -> None:
    with pytest.raises(MaskvalError, match=words) as raised:
        call()
    assert isinstance(raised.value, ValueError)
    assert "\n" not in str(raised.value)
