"""`graspcell render-dataset`: its arguments, workers, scenes and errors."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from cell.layout import default_camera
from experiments.rendering import command as render_dataset
from experiments.rendering import config as render_config
from experiments.rendering.config import RenderDataset
from maskval import Mesh, Pose, bop
from maskval.bop import ImageCamera
from sim.errors import DivergenceError
from sim.images.generated import Recipe, make_image
from sim.images.pictures import LabelledPicture, Shot
from sim.model.parts import load_part
from sim.networks.random_streams import Streams
from tests.experiments.command import command

CAMERA = default_camera()

WRONG = [  # arguments, words that the one line of error must hold
    (["--style", "s3"], ["--style", "s3", "s1", "s2"]),
    (["--object", "cup"], ["unknown object 'cup'", "antenna, handle", ".toml"]),
    (["--images", "0"], ["--images of at least 1", "got 0"]),
    (["--images", "many"], ["--images", "many"]),
    (["--split", "a/b"], ["--split of letters, digits, _ and -", "got 'a/b'"]),
    (["--split", "models"], ["not models"]),
    (["--textured", "1.5"], ["--textured in 0..1", "got 1.5"]),
    (["--distance-m", "0.8", "0.4"], ["--distance-m LOW HIGH in 0.25..3", "got 0.8 0.4"]),
    (["--parts", "5", "2"], ["--parts LOW HIGH in 1..30", "got 5 2"]),
    (["--clutter", "0", "99"], ["--clutter LOW HIGH in 0..30", "got 0 99"]),
    (["--spread-m", "0", "0.3"], ["--spread-m LOW HIGH in 0.01..1", "got 0 0.3"]),
    (["--distance-m", "0.1", "0.4"], ["--distance-m LOW HIGH in 0.25..3", "got 0.1 0.4"]),
    (["--elevation-deg", "50", "nan"], ["--elevation-deg LOW HIGH in 10..90", "got 50 nan"]),
    (["--textured", "nan"], ["--textured in 0..1", "got nan"]),
    (["--samples", "2"], ["--samples of 1, 3, 5, ...", "got 2"]),
    (["--samples", "0"], ["--samples of at least 1", "got 0"]),
    (["--views-per-heap", "3"], ["--views-per-heap that divides 1000", "got 3"]),
    (["--views-per-heap", "0"], ["--views-per-heap of at least 1", "got 0"]),
    (["--rgb", "gif"], ["--rgb", "png", "jpg"]),
    (["--seed", "-1"], ["--seed of at least 0", "got -1"]),
    (["--jobs", "-1"], ["--jobs of at least 0", "got -1"]),
    (["--objets", "handle"], ["--objets", "valid options of render-dataset", "--object", "--textured"]),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG, ids=[" ".join(arguments) for arguments, _ in WRONG])
def test_a_wrong_argument_ends_with_code_2_and_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: list[str], words: list[str]
) -> None:
    told = command(capsys, "render-dataset", "--out", tmp_path / "set", *arguments)
    assert (told.code, told.out) == (2, "")
    assert told.err.startswith("graspcell: error: ")
    assert told.err.count("\n") == 1
    assert [word for word in words if word not in told.err] == []
    assert not (tmp_path / "set").exists()


def test_a_folder_that_holds_something_is_refused_and_left_alone(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "mine.txt").write_text("precious")
    told = command(capsys, "render-dataset", "--out", tmp_path)
    assert (told.code, told.out) == (2, "")
    assert f"{tmp_path} is not empty: expected a new or empty folder" in told.err
    assert told.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
    told = command(capsys, "render-dataset", "--out", tmp_path / "mine.txt")
    assert (told.code, told.err.count("\n")) == (2, 1)
    assert "cannot write to" in told.err


def test_the_pictures_do_not_depend_on_the_number_of_workers(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(render_config, "_BATCH", 1)
    contents = []
    for jobs in (1, 2):
        out = tmp_path / str(jobs)
        told = command(capsys, "render-dataset", "--images", 2, "--samples", 1, "--jobs", jobs, "--out", out)
        assert told.code == 0
        assert "2 pictures" in told.out
        files = sorted(
            path for path in out.rglob("*") if path.is_file() and path.name not in ("config.toml", "manifest.json")
        )
        contents.append({path.relative_to(out): path.read_bytes() for path in files})
    assert len(contents[0]) >= 10
    assert contents[0] == contents[1]


def quick(model: object, renderer: object, streams: Streams, shot: Shot) -> LabelledPicture:
    """Stands in for a style where only files matter."""
    truth = make_image(load_part("antenna").part.mesh, CAMERA, Recipe(parts=(1, 1), clutter=(0, 0)), streams).truth
    black = np.zeros((480, 640, 3), dtype=np.uint8)
    return LabelledPicture(black, np.zeros((480, 640), dtype=np.float32), truth, None)


def first_poses(out: Path, split: str = "test") -> list[Pose]:
    folders = sorted((out / split).iterdir())
    scenes = [bop.read_scene_gt(folder / "scene_gt.json") for folder in folders]
    return [parts[0].X_CO for scene in scenes for parts in scene.values()]


@pytest.fixture
def fast(monkeypatch: pytest.MonkeyPatch) -> Callable[..., RenderDataset]:
    monkeypatch.setitem(render_dataset.STYLES, "s2", quick)

    def run(out: Path, **options: object) -> RenderDataset:
        config = RenderDataset(style="s2", jobs=1, out=out, **options)
        assert render_dataset.render_dataset(config) == 0
        return config

    return run


def test_many_images_go_to_scenes_of_their_own(
    fast: Callable[..., RenderDataset], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fast(tmp_path / "one", images=5)
    monkeypatch.setattr(render_config, "_BATCH", 2)
    monkeypatch.setattr(render_dataset, "IMAGES_PER_SCENE", 2)
    fast(tmp_path / "three", images=5)
    scenes = sorted(path.name for path in (tmp_path / "three" / "test").iterdir())
    assert scenes == ["000000", "000001", "000002"]
    images = [bop.read_scene_camera(tmp_path / "three" / "test" / scene / "scene_camera.json") for scene in scenes]
    assert [list(one) for one in images] == [[0, 1], [0, 1], [0]]
    assert all(isinstance(camera, ImageCamera) for one in images for camera in one.values())
    whole, parted = first_poses(tmp_path / "one"), first_poses(tmp_path / "three")
    assert len(whole) == 5
    for a, b in zip(whole, parted, strict=True):
        assert np.array_equal(a.matrix, b.matrix)


def test_another_split_or_seed_has_other_pictures(fast: Callable[..., RenderDataset], tmp_path: Path) -> None:
    fast(tmp_path / "a", images=2)
    fast(tmp_path / "b", images=2, split="train")
    fast(tmp_path / "c", images=2, seed=1)
    poses = [*first_poses(tmp_path / "a"), *first_poses(tmp_path / "b", "train"), *first_poses(tmp_path / "c")]
    assert len({X.translation.tobytes() for X in poses}) == 6


def test_heaps_that_do_not_rest_end_with_code_1_and_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> LabelledPicture:
        raise DivergenceError("none of 20 heaps came to rest")

    monkeypatch.setitem(render_dataset.STYLES, "s1", never)
    told = command(capsys, "render-dataset", "--images", 1, "--jobs", 1, "--out", tmp_path / "set")
    assert (told.code, told.out) == (1, "")
    assert "error: none of 20 heaps came to rest; the dataset in" in told.err
    assert "is not complete" in told.err


def test_a_mesh_of_ones_own_can_be_rendered(tmp_path: Path, fast: Callable[..., RenderDataset]) -> None:
    text = Path("sim/assets/parts/antenna.toml").read_text().replace('name = "antenna"', 'name = "mine"', 1)
    (tmp_path / "mine.toml").write_text(text)
    fast(tmp_path / "set", images=1, object=str(tmp_path / "mine.toml"))
    assert isinstance(bop.Dataset(tmp_path / "set").mesh(1), Mesh)


@pytest.mark.parametrize(
    ("views", "images", "batches"), [(1, 25, [10, 10, 5]), (4, 45, [20, 20, 5]), (50, 60, [50, 10])]
)
def test_the_views_of_a_heap_are_in_one_batch_and_scene(views: int, images: int, batches: list[int]) -> None:
    made = RenderDataset(images=images, views_per_heap=views).batches
    assert [len(batch) for batch in made] == batches
    assert [number for batch in made for number in batch] == list(range(images))
    assert all(batch[0] % views == 0 for batch in made)
    assert all(
        batch[0] // 1000 == batch[-1] // 1000 for batch in RenderDataset(images=3000, views_per_heap=views).batches
    )


def test_rgb_is_written_as_jpg_on_demand(fast: Callable[..., RenderDataset], tmp_path: Path) -> None:
    fast(tmp_path / "set", images=1, rgb="jpg")
    (rgb,) = (tmp_path / "set" / "test" / "000000" / "rgb").iterdir()
    assert rgb.name == "000000.jpg"
    picture = cv2.imread(str(rgb), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    assert (picture.shape, picture.max()) == ((480, 640, 3), 0)
