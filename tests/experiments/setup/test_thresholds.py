from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.setup.methods import named_methods
from experiments.setup.thresholds import Thresholds, load_thresholds

GOOD = """
refine = 0.5
[grasp.mug]
maskval = 0.25
ensemble-add = 1
[ensemble_add_minimum_m]
mug = 0.002
"""


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_the_preset_paper_has_the_papers_thresholds() -> None:
    paper = load_thresholds("paper")
    assert paper.refine == 0.6
    assert paper.grasp == {
        "antenna": {"ensemble-add": 0.10, "maskval": 0.20},
        "handle": {"ensemble-add": 0.08, "maskval": 0.55},
    }
    assert set(paper.ensemble_add_minimum) == {"antenna", "handle"}
    assert paper.source == "paper"


def test_a_file_of_the_same_form_works_like_a_preset(tmp_path: Path) -> None:
    source = written(tmp_path, GOOD)
    mine = load_thresholds(source)
    assert mine.refine == 0.5
    assert (mine.of("mug", "maskval"), mine.of("mug", "ensemble-add")) == (0.25, 1.0)
    assert mine.ensemble_add_minimum == {"mug": 0.002}
    assert mine.source == source


def test_a_pair_without_threshold_is_refused_with_the_pairs_that_have_one(tmp_path: Path) -> None:
    mine = load_thresholds(written(tmp_path, GOOD))
    with pytest.raises(UsageError, match=r"no grasp\.cup\.maskval; they have mug × maskval, mug × ensemble-add"):
        mine.of("cup", "maskval")
    with pytest.raises(UsageError, match=r"no grasp\.mug\.none"):
        mine.of("mug", "none")


def test_an_unknown_preset_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match=r"unknown thresholds 'papr': expected one of .*paper.*\.toml"):
        load_thresholds("papr")


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"none\.toml does not exist"):
        load_thresholds(str(tmp_path / "none.toml"))


MALFORMED = {
    "no TOML": ("refine = = 1", ["Invalid", "expected refine = u"]),
    "no refine": (GOOD.replace("refine = 0.5", ""), ["key 'refine' is missing", "expected refine = u"]),
    "no grasp": (GOOD.replace("grasp.mug", "grip.mug"), ["key 'grasp' is missing", "[grasp.OBJECT]"]),
    "no minimum": (
        GOOD.replace("[ensemble_add_minimum_m]", "[minimum]"),
        ["key 'ensemble_add_minimum_m' is missing", "[ensemble_add_minimum_m] with OBJECT = m"],
    ),
    "refine above 1": (GOOD.replace("0.5", "1.5"), ["expected refine in [0, 1], got 1.5"]),
    "refine in words": (GOOD.replace("0.5", '"much"'), ["expected refine in [0, 1], got 'much'"]),
    "refine not a number": (GOOD.replace("0.5", "nan"), ["expected refine in [0, 1], got nan"]),
    "refine as a truth": (GOOD.replace("0.5", "true"), ["expected refine in [0, 1], got True"]),
    "grasp below 0": (GOOD.replace("0.25", "-0.25"), ["expected grasp.mug.maskval in [0, 1], got -0.25"]),
    "grasp in words": (GOOD.replace("0.25", '"low"'), ["expected grasp.mug.maskval in [0, 1], got 'low'"]),
    "grasp without object": ("refine = 0.5\n[grasp]\nmaskval = 0.2\n[ensemble_add_minimum_m]\n", ["[grasp.OBJECT]"]),
    "minimum in words": (GOOD.replace("0.002", '"x"'), ["expected ensemble_add_minimum_m.mug in [0, 0.05) m, got 'x'"]),
    "minimum below 0": (GOOD.replace("0.002", "-1.0"), ["expected ensemble_add_minimum_m.mug in [0, 0.05) m, got -1"]),
    "minimum at its scale's end": (GOOD.replace("0.002", "0.05"), ["ensemble_add_minimum_m.mug in [0, 0.05) m"]),
    "least error above 1": (
        GOOD + "[least_error.mug]\nscore = 2\n",
        ["expected least_error.mug.score in [0, 1], got 2"],
    ),
    "least error as a number": (GOOD.replace("[grasp", "least_error = 1\n[grasp"), ["expected a table, got a value"]),
    "minimum as a number": ("refine = 0.5\nensemble_add_minimum_m = 1\n[grasp.mug]", ["[ensemble_add_minimum_m]"]),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_file_is_refused_with_what_is_expected(tmp_path: Path, case: str) -> None:
    text, expected = MALFORMED[case]
    source = written(tmp_path, text)
    with pytest.raises(UsageError) as refusal:
        load_thresholds(source)
    message = str(refusal.value)
    assert source in message
    assert [word for word in expected if word not in message] == []


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "binary.toml"
    path.write_bytes(b"refine = 0.5 # \xff\xfe")
    with pytest.raises(UsageError, match=r"binary\.toml cannot be read"):
        load_thresholds(str(path))


def test_the_preset_derived_has_a_threshold_for_every_method_that_a_test_image_can_judge() -> None:
    derived = load_thresholds("derived")
    assert derived.refine == 0.6
    assert set(derived.ensemble_add_minimum) == {"antenna", "handle"}
    needing = [name for name in named_methods(["all"]) if name not in ("none", "temporal")]
    for part in ("antenna", "handle"):
        assert all(0.0 <= derived.of(part, name) <= 1.0 for name in needing)
        assert derived.caveat(part, "maskval") is None


def test_what_is_told_goes_before_what_is_derived_and_that_before_the_least_error_and_the_methods_own() -> None:
    mine = Thresholds("mine", 0.6, {"mug": {"a": 0.1}}, {}, least_error={"mug": {"b": 0.2}})
    told = mine.with_told(["a=0.3", "my.own:Class=0"], ["a", "my.own:Class"])
    assert [mine.of("mug", method, own=0.9) for method in ("a", "b", "c")] == [0.1, 0.2, 0.9]
    assert [told.of("mug", method, own=0.9) for method in ("a", "b", "my.own:Class")] == [0.3, 0.2, 0.0]
    assert [told.caveat("mug", method) is None for method in ("a", "b", "c", "my.own:Class")] == [
        True,
        False,
        False,
        True,
    ]
    assert "least error" in str(mine.caveat("mug", "b"))
    assert "mine have none; it is the method's own" in str(mine.caveat("mug", "c"))


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("maskval", "METHOD=U of maskval, score, got 'maskval'"),
        ("0.5", "METHOD=U of maskval, score, got '0.5'"),
        ("depth=0.5", "METHOD=U of maskval, score, got 'depth=0.5'"),
        ("maskval=much", r"U in \[0, 1\], got 'maskval=much'"),
        ("maskval=1.5", r"U in \[0, 1\], got 'maskval=1.5'"),
        ("maskval=nan", r"U in \[0, 1\], got 'maskval=nan'"),
    ],
)
def test_a_threshold_of_ones_own_that_is_none_is_refused(option: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        load_thresholds("paper").with_told([option], ["maskval", "score"])


def test_presets_with_trained_networks_are_said_to_be_those_of_the_simulated_ones(tmp_path: Path) -> None:
    preset = load_thresholds("derived", networks=True).with_told(["score=0.3"], ["score", "maskval"])
    assert preset.of("handle", "maskval") == load_thresholds("derived").of("handle", "maskval")
    assert "graspcell dataset --estimator networks" in str(preset.caveat("handle", "maskval"))
    assert preset.caveat("handle", "score") is None
    own = tmp_path / "own.toml"
    own.write_text("refine = 0.6\n[grasp.handle]\nmaskval = 0.4\n[ensemble_add_minimum_m]\n")
    assert load_thresholds(str(own), networks=True).caveat("handle", "maskval") is None
