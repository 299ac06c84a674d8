"""`python -m benchmarks.methods`: what a call of each uncertainty method costs, on generated test images.

Each method judges the same images in turn; a call's process time is divided by the poses in the image. What feeds a
method is not in it: networks, and the depth camera. The temporal method remembers all images before.
"""

import time
from statistics import median

import numpy as np

from cell.layout import default_camera
from experiments.setup.methods import METHODS, Context, make_uncertainty
from experiments.setup.thresholds import Thresholds
from maskval import Camera, Correspondences, Estimates, Mesh, Pose, UncertaintyMethod
from sim.images.generated import Recipe, draw_nearest, make_image
from sim.instance_ids import PIXEL_CENTER
from sim.model.parts import load_part, part_names
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.image_estimates import estimate_image
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams

IMAGES, ROUNDS, POINTS = 20, 5, 200


def images(part: str) -> list[tuple[Estimates, FrameTruth]]:
    """Estimates with everything that a method can ask for, and the truth."""
    model, camera = load_part(part), default_camera()
    mesh, noise = model.part.mesh, load_noise(model.noise)
    made = []
    for number in range(IMAGES):
        streams = Streams(0, number, model.part.name)
        image = make_image(mesh, camera, Recipe(), streams)
        found = estimate_image(image.truth, noise, streams)
        masks = np.array([one.mask for one in found.detections], dtype=bool).reshape(-1, camera.height, camera.width)
        estimates = Estimates(
            camera=camera,
            mesh=mesh,
            masks=masks,
            poses=found.poses,
            scores=np.array([one.score for one in found.detections]),
            pixel_center=PIXEL_CENTER,
            depth=draw_nearest(image.bodies, camera)[1],
            X_BC=Pose.from_translation((0.2 * number, 0.0, 0.0)),
            correspondences=tuple(points_of(mesh, pose, camera) for pose in found.poses[0]),
            rgb=np.random.default_rng(number).integers(0, 256, (camera.height, camera.width, 3), dtype=np.uint8),
        )
        made.append((estimates, image.truth))
    return [one for one in made if len(one[0])]


def points_of(mesh: Mesh, X_CO: Pose, camera: Camera) -> Correspondences:
    """As many correspondences as a pose network of the package gives, 2 px off."""
    rng = np.random.default_rng(0)
    points_O = mesh.vertices[rng.integers(len(mesh.vertices), size=POINTS)]
    pixels = camera.project(X_CO.apply(points_O)) + rng.normal(0.0, 2.0, (POINTS, 2))
    return Correspondences(points_O, pixels, np.full(POINTS, 2.0))


def cost_us(part: str, name: str, seen: list[tuple[Estimates, FrameTruth]]) -> float:
    """Median over the rounds of the process time per pose, µs."""
    model = load_part(part)
    thresholds = Thresholds("none", 0.0, {}, {model.part.name: 0.0})
    rounds = []
    for number in range(ROUNDS + 1):
        latest_truth = LatestTruth()
        method: UncertaintyMethod = make_uncertainty(
            name, Context(model.part, thresholds, Streams(0, 0, model.part.name), latest_truth)
        )
        spent = 0.0
        for estimates, truth in seen:
            latest_truth.keep(truth)
            begin = time.process_time()
            method(estimates)
            spent += time.process_time() - begin
        if number > 0:  # the first round compiles
            rounds.append(1e6 * spent / sum(len(estimates) for estimates, _ in seen))
    return median(rounds)


def main() -> None:
    """Prints µs per pose of every method and part."""
    parts = part_names()
    sets = {part: images(part) for part in parts}
    print(f"µs of process time per pose, median of {ROUNDS} rounds over {IMAGES} images")
    print(f"{'method':22}" + "".join(f"{part:>10}" for part in parts))
    for name in METHODS:
        print(f"{name:22}" + "".join(f"{cost_us(part, name, sets[part]):10.1f}" for part in parts), flush=True)


if __name__ == "__main__":
    main()
