"""Options of the environment whose steps are decisions."""

import gc
import os
import weakref
from typing import Any

import gymnasium
import numpy as np
import pytest

from maskval import MaskVal, MaskvalError
from sim.errors import EnvOptionError, GraphicsError, NoiseFileError, SimError
from sim.gym.decision_env import GraspCellEnv
from sim.gym.motion_env import GraspCellMotionEnv
from sim.gym.options import Rewards
from sim.model import renderer
from sim.model.conditions import Conditions
from tests.sim.gym.decisions import made, same

ODD: tuple[Any, ...] = (None, -1, 1e9, float("nan"), "x", b"x", [[1]], {}, (1,), object(), 10**400, {"x": 3})
FITS = {"render_mode": (None,), "networks": (None,)}  # of the odd ones
NAMES = (
    "part",
    "n_parts",
    "slot_time",
    "methods",
    "estimator",
    "networks",
    "speed",
    "conditions",
    "rewards",
    "max_detections",
    "images",
    "truth",
    "render_mode",
    "render_size",
)


def refused(words: str, call: Any, *arguments: Any, **options: Any) -> None:
    """The call raises an error of this library, in one line of readable length with these words."""
    with pytest.raises((SimError, MaskvalError), match=words) as error:
        call(*arguments, **options)
    message = str(error.value)
    assert "\n" not in message
    assert len(message) < 1500


@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("name", NAMES)
def test_an_odd_value_of_an_option_is_refused_when_the_environment_is_made(name: str, value: Any) -> None:
    if any(value is fit for fit in FITS.get(name, ())):
        return
    refused(name if name not in ("part",) else "part|object", GraspCellEnv, **{name: value})


@pytest.mark.parametrize("name", ["light", "friction", "belt_speed", "hand_eye_error_mm", "clutter"])
@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
def test_an_odd_disturbance_or_reward_is_refused(name: str, value: Any) -> None:
    refused(name.replace("_", "-"), Conditions, **{name: value})
    if value not in (-1, 1e9):
        refused("second", Rewards, second=value)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"images": "rgb"}, "expected images to be a tuple of names, got 'rgb'"),
        ({"images": ("rgb", "rgb")}, "expected different names for images"),
        ({"conditions": {}}, "expected conditions to be a sim.model.conditions.Conditions, got {}"),
        ({"rewards": {}}, "expected rewards to be a sim.gym.options.Rewards, got {}"),
        (
            {"methods": {"mine": "maskval"}},
            "each a maskval.UncertaintyMethod that is called with estimates, got 'maskval'",
        ),
        ({"methods": {3: MaskVal()}}, "for 3"),
        ({"n_part": 3}, "unknown options n_part: expected part, n_parts, .* did you mean n_parts?"),
        ({"render_size": (480, 0)}, "expected render_size's width of 1 to 1920, got 0"),
        ({"n_parts": True}, "expected n_parts of 1 to 8, got True"),
        ({"n_parts": 9}, "expected n_parts of 1 to 8, got 9"),
        ({"slot_time": 0.0}, "expected slot_time above 0 and at most 3600, got 0.0"),
        ({"max_detections": 0}, "expected max_detections of 1 to 100, got 0"),
        ({"methods": "maskval"}, "expected methods to be a tuple of names or a mapping, got 'maskval'"),
        ({"methods": ()}, "expected methods to be a tuple of names or a mapping"),
        ({"methods": ("magic",)}, "unknown methods 'magic': expected none, maskval, .*, temporal"),
        ({"images": ("thermal",)}, "unknown images 'thermal': expected rgb, depth, masks"),
        ({"estimator": "perfect"}, "unknown estimator 'perfect': expected oracle, noisy, networks"),
        ({"estimator": "networks", "networks": "nowhere"}, "expected trained networks in nowhere"),
        ({"networks": "weights"}, "expected no networks with the estimator noisy, got 'weights'"),
        ({"methods": ("inliers",)}, "unknown methods 'inliers'"),
        ({"speed": "warp"}, "unknown speed 'warp': expected ur-default"),
        ({"part": "spoon"}, "spoon"),
        ({"render_mode": "ascii"}, "unknown render_mode 'ascii'"),
    ],
)
def test_options_that_cannot_be_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        GraspCellEnv(**options)


def test_rewards_and_reset_options_are_checked(env: GraspCellEnv) -> None:
    with pytest.raises(EnvOptionError, match="expected a finite reward second, got nan"):
        Rewards(second=float("nan"))
    with pytest.raises(EnvOptionError, match="unknown reset options episode: expected experiment, noise"):
        env.reset(options={"episode": 3})
    with pytest.raises(NoiseFileError, match=r"unknown noise parameter 'pose\.lateral'"):
        env.reset(options={"noise": {"pose.lateral": 3.0}})


def test_exact_estimates_take_no_noise(oracle: GraspCellEnv) -> None:
    with pytest.raises(EnvOptionError, match="expected no noise with the estimator oracle"):
        oracle.reset(options={"noise": {"pose.lateral_mm": 3.0}})


def test_other_noise_holds_for_one_episode(env: GraspCellEnv) -> None:
    def u_of(**options: Any) -> Any:
        observation, _ = env.reset(seed=3, options=options)
        return observation["u_maskval"]

    plain, rough = u_of(), u_of(noise={"pose.lateral_mm": 8.0, "pose.outlier_probability": 0.0})
    seen = np.flatnonzero(plain)
    assert (rough[seen] > plain[seen]).mean() > 0.5
    assert same(u_of(), plain)


@pytest.mark.parametrize("value", [value for value in ODD if value is not None], ids=lambda value: type(value).__name__)
def test_an_odd_seed_or_option_of_a_reset_is_refused_and_the_environment_goes_on(env: GraspCellEnv, value: Any) -> None:
    refused("seed", env.reset, seed=value)
    refused("experiment", env.reset, options={"experiment": value})
    refused("noise|lateral_mm", env.reset, options={"noise": {"pose.lateral_mm": value}})
    if value != {}:
        refused("reset options", env.reset, options=value)
        refused("noise", env.reset, options={"noise": value})
    assert env.reset(seed=3)[1]["experiment"] == 0


@pytest.mark.parametrize("kind", [GraspCellEnv, GraspCellMotionEnv])
def test_close_frees_the_world_and_the_next_step_asks_for_a_reset(kind: Any) -> None:
    env = kind(n_parts=1, estimator="oracle")
    gc.collect()
    gc.disable()  # what is freed is freed by close alone
    try:
        env.reset(seed=0)
        world = weakref.ref(env.unwrapped._cell.world)
        assert world() is not None
        env.close()
        assert world() is None
    finally:
        gc.enable()
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(env.action_space.sample())
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.render()
    env.close()


def test_opengl_of_the_process_that_forked_this_one_is_an_error_with_the_remedy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    env = made(images=("rgb",))
    try:
        env.reset(seed=0)
        here = os.getpid()
        with monkeypatch.context() as child:
            child.setattr(os, "getpid", lambda: here + 1)
            with pytest.raises(GraphicsError, match=r"forked by one that had opened OpenGL.*get_context.\"spawn\""):
                env.reset(seed=1)
            with pytest.raises(GraphicsError, match="spawn"):
                renderer.check_not_forked()
        env.reset(seed=1)
    finally:
        env.close()
