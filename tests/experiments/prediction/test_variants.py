import math

import numpy as np
import pytest

from cell.records import Tally
from experiments.cli import main
from experiments.prediction.counting import Counted
from experiments.prediction.setting import Setting
from experiments.prediction.variants import VARIANTS
from experiments.results.first_attempts import FirstAttempts
from experiments.setup.error_models import error_model, error_model_of
from experiments.setup.thresholds import load_thresholds
from maskval import Pose
from sim.networks.domain_gap import BASE_REACH, Gap, Reach
from sim.networks.noise_model import PartNoise, load_noise
from sim.networks.pose_noise import PoseLatents, core_scale, outlier_probability, pose_error

GAP = Gap(core_scale=1.5, outlier_odds=25.0)
HANDLE = load_noise("handle")
MEMBER = {"pose.second_scale": 1.4, "mask.drop_probability": 0.02}
RENDERED = HANDLE.changed(MEMBER)
LATENTS = PoseLatents.from_vector(0.7, np.linspace(-0.6, 1.2, PoseLatents.COUNT))
AHEAD = Pose.from_translation((0.0, 0.0, 0.8))


def setting_of(variant: str) -> Setting:
    return VARIANTS[variant](Setting(load_thresholds("paper")))


def model_of(variant: str, gap: Gap = GAP) -> PartNoise:
    """The handle's error model in the world of one accepted set and one gap, under a variant."""
    setting = setting_of(variant)
    spec = setting.spec("handle", "none", error_model(HANDLE, MEMBER, gap, setting.reach), 0)
    return HANDLE.changed(dict(spec.noise))


def odds(p: float) -> float:
    return p / (1.0 - p)


def core_mm(noise: PartNoise, network: int) -> float:
    """Standard deviation of the lateral core of a part of which a fifth is hidden, mm."""
    return noise.pose.lateral_mm * core_scale(0.8, LATENTS, noise.pose, network=network)


def outlier_odds(noise: PartNoise, network: int) -> float:
    return odds(outlier_probability(0.8, LATENTS, noise.pose, network=network))


def test_the_base_changes_the_same_numbers_by_the_same_bits_as_the_gap_was_fitted_with() -> None:
    p = RENDERED.pose.outlier_probability
    multiplied = 25.0 * p / (1.0 - p)
    expected = MEMBER | {
        "pose.lateral_mm": 1.5 * RENDERED.pose.lateral_mm,
        "pose.rotation_deg": 1.5 * RENDERED.pose.rotation_deg,
        "pose.outlier_probability": multiplied / (1.0 + multiplied),
    }
    assert setting_of("base").reach == BASE_REACH == Reach(second=1.0, detector=0.0)
    assert dict(error_model(HANDLE, MEMBER, GAP)) == expected
    assert dict(error_model(HANDLE, MEMBER, GAP, BASE_REACH)) == expected


def test_outliers_along_the_ray_hardly_turn_or_leave_the_ray() -> None:
    gross = np.zeros(PoseLatents.COUNT)
    gross[14:16] = -9.0  # an outlier of both networks
    gross[16:18] = 3.0  # not a flip
    gross[18:24] = 1.0  # one standard deviation in all directions
    noise = model_of("outliers-along-the-ray")
    error, flipped = pose_error(AHEAD, np.zeros(3), 1.0, PoseLatents.from_vector(0.0, gross), noise.pose, network=0)
    assert not flipped
    assert error == pytest.approx([0.003, 0.003, 0.080, *[math.radians(3.0)] * 3])
    gross[16:18] = -3.0  # below the quantile of 8 %, -1.4
    _, flipped = pose_error(AHEAD, np.zeros(3), 1.0, PoseLatents.from_vector(0.0, gross), noise.pose, network=0)
    assert flipped


def test_a_gap_on_S1_only_leaves_S2_as_on_rendered_images() -> None:
    real = model_of("gap-first-only")
    assert core_mm(real, 1) == pytest.approx(core_mm(RENDERED, 1), rel=1e-12)
    assert outlier_odds(real, 1) == pytest.approx(outlier_odds(RENDERED, 1), rel=1e-12)
    assert core_mm(real, 0) == pytest.approx(1.5 * core_mm(RENDERED, 0), rel=1e-12)
    assert outlier_odds(real, 0) == pytest.approx(25.0 * outlier_odds(RENDERED, 0), rel=1e-12)
    assert core_mm(model_of("base"), 1) == pytest.approx(1.5 * core_mm(RENDERED, 1), rel=1e-12)
    assert outlier_odds(model_of("base"), 1) == pytest.approx(25.0 * outlier_odds(RENDERED, 1), rel=1e-12)


def test_a_share_of_the_gap_is_an_exponent() -> None:
    half = HANDLE.changed(dict(error_model(HANDLE, MEMBER, GAP, Reach(second=0.5))))
    assert core_mm(half, 1) == pytest.approx(math.sqrt(1.5) * core_mm(RENDERED, 1), rel=1e-12)
    assert outlier_odds(half, 1) == pytest.approx(5.0 * outlier_odds(RENDERED, 1), rel=1e-12)


def test_the_gap_on_S1_only_goes_with_outliers_of_its_own() -> None:
    own, shared = model_of("gap-first-only-outliers-own"), model_of("gap-first-only")
    assert own == shared.changed({"pose.second_outlier_correlation": 0.0, "pose.second_same_content_share": 0.0})
    assert own != shared


def test_the_gap_of_masks_scales_the_outline_and_multiplies_the_odds_of_drops_and_misses() -> None:
    real = model_of("gap-masks")
    assert real.mask.field_cells == pytest.approx(1.5 * RENDERED.mask.field_cells)
    assert odds(real.mask.drop_probability) == pytest.approx(25.0 * odds(0.02))
    assert odds(real.mask.miss_probability) == pytest.approx(25.0 * odds(RENDERED.mask.miss_probability))
    assert real.pose == model_of("base").pose


def test_what_is_certain_stays_certain_under_a_gap() -> None:
    sure = HANDLE.changed({"mask.drop_probability": 1.0, "mask.miss_probability": 0.0})
    values = GAP.noise(sure, Reach(detector=1.0))
    assert (values["mask.drop_probability"], values["mask.miss_probability"]) == (1.0, 0.0)


def test_half_of_each_error_is_renewed_in_every_picture() -> None:
    assert model_of("errors-renewed") == model_of("base").changed({"view.renewed_share": 0.5})


@pytest.mark.parametrize("value", [-0.1, 1.1, float("nan")])
def test_a_share_of_the_gap_out_of_range_is_refused(value) -> None:
    with pytest.raises(ValueError, match=r"expected second in \[0, 1\], got"):
        Reach(second=value)


def test_a_prediction_runs_each_variant_in_its_own_worlds(tmp_path, monkeypatch) -> None:
    noise = {}

    def counted(specs, jobs, description):
        noise[description] = [spec.noise for spec in specs]
        count = Tally(parts=8, tp=8, fp=0, fn=0, void=0, unreachable=0, timeouts=0, duration=9.0)
        return [Counted(count, FirstAttempts(8, 8, 0)) for _ in specs]

    monkeypatch.setattr("experiments.prediction.command.count_all", counted)
    with pytest.raises(SystemExit, match=r"^0$"):
        main(
            ["predict", "--objects", "handle", "--methods", "none", "--worlds", "2", "--experiments", "1"]
            + ["--variants", "base", "gap-first-only", "--out", str(tmp_path)]
        )
    assert noise["base"] == [error_model_of("handle", "fitted", index) for index in range(2)]
    assert noise["gap-first-only"] == [
        error_model_of("handle", "fitted", index, Reach(second=0.0)) for index in range(2)
    ]
    assert noise["base"] != noise["gap-first-only"]
