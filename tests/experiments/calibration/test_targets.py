import math

import numpy as np
import pytest

from experiments.calibration.noise_file import rewrite
from experiments.calibration.targets import Prior, load_calibration, values_at
from experiments.errors import UsageError
from experiments.results.paper import dataset_figures
from sim.networks.noise_model import load_noise, noise_text, read_noise

GOOD = """
[target.maskval]
spearman = { value = 0.9, sd = 0.01 }
[prior.pose]
lateral_mm = { center = 0.5, spread = 0.5 }
"""


def test_the_presets_hold_the_figures_of_the_papers_dataset_tables() -> None:
    antenna, handle = dataset_figures("antenna"), dataset_figures("handle")
    assert [antenna["mask", name] for name in ("ap_50_95", "ap_50", "ar_100")] == [0.947, 0.989, 0.968]
    assert [handle["mask", name] for name in ("ap_50_95", "ap_50", "ar_100")] == [0.873, 0.990, 0.904]
    for name, paper in (("spearman", (0.72, 0.58, 0.70, 0.56)), ("auc_ar", (0.66, 0.523, 0.81, 0.60))):
        assert (
            tuple(part[method, name] for part in (antenna, handle) for method in ("maskval", "ensemble-add")) == paper
        )
    assert (antenna["maskval", "u_tg"], antenna["ensemble-add", "u_tg"]) == (0.20, 0.10)
    assert (handle["maskval", "u_tg"], handle["ensemble-add", "u_tg"]) == (0.55, 0.08)
    assert dataset_figures("brick") == {}


@pytest.mark.parametrize("part", ["antenna", "handle"])
def test_both_presets_are_about_parameters_that_exist(part) -> None:
    calibration = load_calibration(part, load_noise(part))
    assert len(calibration.targets) == 9
    assert {prior.section for prior in calibration.priors} == {"mask", "pose"}


@pytest.mark.parametrize("part", ["antenna", "handle"])
def test_the_parameters_whose_source_is_a_fit_are_those_that_are_fitted(part) -> None:
    section, fitted = "", set()
    for line in noise_text(part).splitlines():
        if line.startswith("["):
            section = line.split("]")[0].strip("[")
        elif line.split("; ")[-1].startswith("fitted"):
            fitted.add(f"{section}.{line.split(' = ')[0]}")
    assert fitted == {prior.name for prior in load_calibration(part, load_noise(part)).priors}


def test_a_prior_is_normal_in_the_logarithm_the_logit_or_the_artanh() -> None:
    size, share, correlation = (
        Prior("pose.lateral_mm", 0.5, 0.5),
        Prior("mask.drop_probability", 0.2, 0.7),
        Prior("pose.second_core_correlation", 0.3, 0.4),
    )
    assert size.value(2.0) == pytest.approx(0.5 * math.e)
    odds = 0.2 / 0.8 * math.exp(-0.7)
    assert share.value(-1.0) == pytest.approx(odds / (1 + odds))
    assert math.atanh(correlation.value(1.5)) == pytest.approx(math.atanh(0.3) + 0.6)
    for prior in (size, share, correlation):
        assert prior.z(prior.value(-0.7)) == pytest.approx(-0.7)


def test_no_number_of_standard_deviations_leaves_a_parameters_range() -> None:
    noise = load_noise("handle")
    priors = load_calibration("handle", noise).priors
    for z in (-6.0, 0.0, 6.0):
        noise.changed(values_at(priors, np.full(len(priors), z)))  # raises out of range
    assert values_at(priors, np.zeros(len(priors))) == pytest.approx({prior.name: prior.center for prior in priors})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[target", "Expected"),
        ("[target.mask]", "the key 'prior' is missing"),
        (GOOD.replace("spearman ", "spear "), "unknown target maskval.spear"),
        (GOOD.replace("target.maskval", "target.masks"), "unknown target masks.spearman"),
        (
            GOOD.replace("maskval]\nspearman", "mask]\nap_50"),
            "expected a target of maskval or ensemble-add",
        ),
        (
            GOOD + "[prior.timing]\npose_s = { center = 0.2, spread = 0.5 }",
            "prior timing.pose_s has no target",
        ),
        (GOOD.replace("sd = 0.01", "sd = 0"), "expected sd above 0, got 0"),
        (GOOD.replace("value = 0.9", "value = 'x'"), "expected value to be a number, got 'x'"),
        (GOOD.replace("lateral_mm", "lateral"), "unknown noise parameter 'pose.lateral'"),
        (GOOD.replace("center = 0.5", "center = 0"), "inside its parameter's range"),
        (GOOD.replace("center = 0.5", "center = -1"), "expected a number in"),
        (GOOD.replace(", spread = 0.5", ""), "the key 'spread' is missing"),
    ],
)
def test_a_malformed_file_is_refused_with_the_reason(tmp_path, text, words) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=words):
        load_calibration(str(path), load_noise("antenna"))


def test_an_unknown_preset_names_those_that_exist() -> None:
    with pytest.raises(UsageError, match="no calibration for 'brick': expected one of antenna, handle"):
        load_calibration("brick", load_noise("antenna"))


def test_a_rewritten_noise_file_has_the_new_values_and_keeps_every_comment() -> None:
    text = noise_text("antenna")
    new = rewrite(text, {"pose.lateral_mm": (0.61, "fitted, 0.5 to 0.7"), "mask.difficulty_gain": (0.2, "fitted")})
    assert read_noise(new, "new") == load_noise("antenna").changed(
        {"pose.lateral_mm": 0.61, "mask.difficulty_gain": 0.2}
    )
    before, after = text.splitlines(), new.splitlines()
    changed = [(one, other) for one, other in zip(before, after, strict=True) if one != other]
    assert len(changed) == 2
    for one, other in changed:
        assert one.split("# ")[1].rsplit("; ", 1)[0] == other.split("# ")[1].rsplit("; ", 1)[0]
    assert changed[0][1].endswith("; fitted, 0.5 to 0.7")


def test_rewriting_a_line_that_is_not_there_is_refused() -> None:
    with pytest.raises(KeyError, match=r"pose\.lateral"):
        rewrite(noise_text("antenna"), {"pose.lateral": (1.0, "fitted")})
