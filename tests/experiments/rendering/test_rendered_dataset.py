"""A rendered dataset: the folder is read by `maskval.bop` and judged without MuJoCo."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.layout import default_camera
from experiments.rendering import command as render_dataset
from experiments.rendering.config import RenderDataset
from maskval import bop, depth_image, mask_iou
from maskval.bop import GroundTruth, GroundTruthInfo
from sim.model.parts import load_part
from tests.experiments.command import command
from tests.maskval.rasteriser import rasterise

CAMERA = default_camera()
IMAGES = 4
STEP_M = 1e-4  # of the depth images
TARGETS = "test_targets_bop19.json"


class Rendered:
    """A dataset as `maskval.bop` reads it."""

    def __init__(self, folder: Path, object_: str) -> None:
        self.folder, self.mesh = folder, load_part(object_).part.mesh
        self.scene_folder = folder / "test" / "000000"
        self.scene = bop.Dataset(folder).scene(0)

    def parts(self) -> list[tuple[int, int, GroundTruth, GroundTruthInfo]]:
        """Number of the image and of the part in it, pose and info of every part."""
        return [(im, i, *part) for im in range(IMAGES) for i, part in enumerate(self.scene.parts(im))]

    def mask(self, im_id: int, part: int, *, visible: bool) -> NDArray[np.bool_]:
        return bop.read_mask(bop.mask_path(self.scene_folder, im_id, part, visible=visible))

    def depth(self, im_id: int) -> NDArray[np.float64]:
        scale = self.scene.cameras[im_id].depth_scale
        return bop.read_depth(self.scene_folder / "depth" / f"{im_id:06d}.png", scale)

    def rgb(self, im_id: int) -> NDArray[np.uint8]:
        image = cv2.imread(str(self.scene_folder / "rgb" / f"{im_id:06d}.png"), cv2.IMREAD_UNCHANGED)
        assert image is not None
        return image


@pytest.fixture(scope="module", params=[("s1", "handle", 3), ("s2", "antenna", 1)], ids=lambda given: given[0])
def rendered(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Rendered:
    style, object_, samples = request.param
    folder = tmp_path_factory.mktemp(style) / "set"
    config = RenderDataset(style=style, object=object_, images=IMAGES, samples=samples, seed=4, jobs=1, out=folder)
    assert render_dataset.render_dataset(config) == 0
    return Rendered(folder, object_)


def test_the_folder_is_whole(rendered: Rendered) -> None:
    files = {str(path.relative_to(rendered.folder)) for path in rendered.folder.rglob("*") if path.is_file()}
    scene = {f"test/000000/{name}" for name in ("scene_camera.json", "scene_gt.json", "scene_gt_info.json")}
    images = {f"test/000000/{kind}/{im:06d}.png" for kind in ("rgb", "depth") for im in range(IMAGES)}
    parts = rendered.parts()
    assert len(parts) >= 2 * IMAGES
    masks = {f"test/000000/{kind}/{im:06d}_{i:06d}.png" for kind in ("mask", "mask_visib") for im, i, *_ in parts}
    models = {"models/obj_000001.ply", "models/models_info.json"}
    others = {"camera.json", "config.toml", "manifest.json", "test_targets_bop19.json"}
    assert files == scene | images | masks | models | others
    for im in range(IMAGES):
        assert (rendered.rgb(im).shape, rendered.rgb(im).dtype) == ((480, 640, 3), np.uint8)
        assert np.array_equal(rendered.scene.cameras[im].K, CAMERA.K)
    camera = json.loads((rendered.folder / "camera.json").read_text())
    assert camera == {"cx": 320, "cy": 240, "fx": 600, "fy": 600, "width": 640, "height": 480, "depth_scale": 0.1}


def test_the_model_is_the_part_in_millimetres(rendered: Rendered) -> None:
    mesh = bop.Dataset(rendered.folder).mesh(1)
    assert mesh.vertices == pytest.approx(rendered.mesh.vertices, abs=1e-9)
    (info,) = bop.Dataset(rendered.folder).models().values()
    assert info.diameter_m == pytest.approx(rendered.mesh.diameter)
    raw = json.loads((rendered.folder / "models" / "models_info.json").read_text())["1"]
    assert raw["size_x"] == pytest.approx(1000 * np.ptp(rendered.mesh.vertices[:, 0]))


def test_whole_masks_are_the_projected_triangles(rendered: Rendered) -> None:
    compared = 0
    for im, i, truth, _ in rendered.parts():
        mask = rendered.mask(im, i, visible=False)
        drawn = rasterise(rendered.mesh.vertices, rendered.mesh.faces, truth.X_CO, CAMERA, pixel_center=0.5)
        if drawn.sum() > 100:
            compared += 1
            assert mask_iou(mask, drawn) > 0.999
    assert compared >= IMAGES


def test_visible_masks_are_where_no_other_thing_is_nearer(rendered: Rendered) -> None:
    """Depth comes from the z-buffer of all bodies, the part's own depth from the kernel in NumPy."""
    seen, hidden = [], []
    for im, i, truth, _ in rendered.parts():
        own = depth_image(rendered.mesh, truth.X_CO, CAMERA, pixel_center=0.5, implementation="numpy")
        visible = rendered.mask(im, i, visible=True)
        assert not (visible & (own == 0)).any()
        measured = rendered.depth(im)
        seen.append((measured - own)[visible])
        hidden.append((measured - own)[(own > 0) & ~visible])
    on_parts = np.abs(np.concatenate(seen))
    assert len(on_parts) > 3000
    # But for pixels on an edge of the part itself, behind which it goes on: the rasterisers snap corners differently.
    assert np.mean(on_parts > STEP_M / 2 + 5e-5) < 1e-3
    assert len(np.concatenate(hidden)) > 100
    in_front = np.concatenate(hidden)
    assert np.mean(in_front < STEP_M) > 0.98  # but for pixels on the outline


def test_masks_of_an_image_share_no_pixel_and_numbers_are_counted_in_them(rendered: Rendered) -> None:
    for im in range(IMAGES):
        masks = [rendered.mask(im, i, visible=True) for i in range(len(rendered.scene.parts(im)))]
        assert np.sum(masks, axis=0).max() <= 1
    for im, i, truth, info in rendered.parts():
        whole, visible = (rendered.mask(im, i, visible=flag) for flag in (False, True))
        assert info.px_count_visib == visible.sum()
        assert info.visib_fract == pytest.approx(visible.sum() / info.px_count_all)
        assert info.px_count_valid == np.count_nonzero(whole & (rendered.depth(im) > 0))
        # The whole silhouette on an image of three times the size, as BOP's toolkit counts it.
        large = type(CAMERA)(600, 600, 320 + 640, 240 + 480, 3 * 640, 3 * 480)
        drawn = rasterise(rendered.mesh.vertices, rendered.mesh.faces, truth.X_CO, large, pixel_center=0.5)
        assert info.px_count_all == pytest.approx(drawn.sum(), abs=3)
        if visible.any():
            rows, columns = np.nonzero(visible)
            box = (columns.min(), rows.min(), columns.max() - columns.min(), rows.max() - rows.min())
            assert info.bbox_visib == box
            rows, columns = np.nonzero(drawn)
            box = (columns.min() - 640, rows.min() - 480, np.ptp(columns), np.ptp(rows))
            assert info.bbox_obj == pytest.approx(box, abs=1)
        else:
            assert info.bbox_visib == info.bbox_obj == (-1, -1, -1, -1)


def test_colours_change_at_the_outlines_of_visible_parts(rendered: Rendered) -> None:
    at_outlines, anywhere = [], []
    for im in range(IMAGES):
        grey = rendered.rgb(im).astype(np.float32).mean(axis=2)
        assert 15 < grey.mean() < 240
        slope = np.hypot(*np.gradient(cv2.GaussianBlur(grey, (0, 0), 1.0)))
        anywhere.append(slope.mean())
        for i in range(len(rendered.scene.parts(im))):
            mask = rendered.mask(im, i, visible=True).astype(np.uint8)
            outline = cv2.dilate(mask, np.ones((3, 3), np.uint8)) != cv2.erode(mask, np.ones((3, 3), np.uint8))
            at_outlines.append(slope[outline])
    assert np.concatenate(at_outlines).mean() > 3 * np.mean(anywhere)


def test_targets_are_the_parts_of_which_a_tenth_is_visible(rendered: Rendered) -> None:
    counts = {target.im_id: target.inst_count for target in bop.read_targets(rendered.folder / TARGETS)}
    expected = {im: sum(info.visib_fract >= 0.1 for _, info in rendered.scene.parts(im)) for im in range(IMAGES)}
    assert counts == {im: count for im, count in expected.items() if count}
    assert sum(counts.values()) >= IMAGES


def test_uq_trusts_the_true_poses_of_the_dataset(rendered: Rendered, capsys: pytest.CaptureFixture[str]) -> None:
    parts = [part for part in rendered.parts() if part[3].visib_fract > 0.98]
    results = [bop.PoseResult(0, im, 1, 1.0, truth.X_CO, 0.1) for im, _, truth, _ in parts]
    assert len(results) >= 3
    path = rendered.folder.parent / "results.csv"
    bop.write_results(path, results)
    told = command(
        capsys, "uq", "--dataset", rendered.folder, "--results", path, "--masks", "mask_visib", "--resamples", 5
    )
    assert told.code == 0, told.err
    assert "warning" not in told.err
    rows = told.out.split("\n\n")[0].splitlines()[1:]
    assert len(rows) == len(results)
    assert max(float(row.rsplit(",", 1)[1]) for row in rows) < 0.03
