"""The options of the learning environments. Setting them needs no engine."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import get_args

from cell.arm.limits import PRESETS
from cell.interfaces import Image, Outcome
from maskval import METHODS, NETWORK_METHODS, UncertaintyMethod, needs_of
from maskval.inputs.spelling import is_finite, shown
from sim.errors import EnvOptionError
from sim.gym.checks import check_kind, check_name, check_names, check_number, check_whole
from sim.model.conditions import Conditions
from sim.networks.estimators import Kind

LEARNED = "networks"
ESTIMATORS = (*get_args(Kind), LEARNED)
IMAGES = ("rgb", "depth", "masks")
MOST_TIME = 3600.0  # s of a slot: a part takes 20
MOST_DETECTIONS = 100  # eight parts lie on the belt


@dataclass(frozen=True, slots=True)
class Rewards:
    """The weights of a step's reward, which is the sum of what happened in it.

    Attributes:
        true_positive: for a part in its slot.
        false_positive: for an attempt that ended in a collision, a dropped or a misplaced part.
        second: for every second of the cell's clock.
        invalid: for an action that the mask rules out.
    """

    true_positive: float = 1.0
    false_positive: float = -1.0
    second: float = -0.01
    invalid: float = -0.1

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not is_finite(value):
                raise EnvOptionError(f"expected a finite reward {entry.name}, got {shown(value)}")

    def of(self, ends: Iterable[Outcome | None], seconds: float) -> float:
        """The reward of slots with these outcomes, None for a time-out, and of the time that has passed."""
        outcomes = [outcome for outcome in ends if outcome is not None]
        return (
            self.second * seconds
            + self.true_positive * sum(outcome.is_true_positive for outcome in outcomes)
            + self.false_positive * sum(outcome.is_false_positive for outcome in outcomes)
        )


@dataclass(frozen=True, slots=True)
class EnvOptions:
    """The options of both environments, which `gymnasium.make` takes by name.

    Attributes:
        part: name or TOML file of the part.
        n_parts: how many lie on the belt, 1 to 8; each has one time slot.
        slot_time: s per part.
        methods: names in `maskval.METHODS`, with networks also in `maskval.NETWORK_METHODS`, or uncertainty methods by
            names of the user's own.
        estimator: "noisy", "oracle", or "networks" for trained ones.
        networks: folder of trained networks; those that come along for the part by default.
        speed: name of the speed preset.
        conditions: what disturbs the cell.
        rewards: the weights of the reward.
        max_detections: how many detections an observation has room for; it holds those of the best scores.
        images: "rgb", "depth" and "masks", whichever an observation holds.
        truth: whether `info` holds the truth.
    """

    part: str = "antenna"
    n_parts: int = 8
    slot_time: float = 20.0
    methods: tuple[str, ...] | Mapping[str, UncertaintyMethod] = ("maskval",)
    estimator: str = "noisy"
    networks: str | None = None
    speed: str = "ur-default"
    conditions: Conditions = field(default_factory=Conditions)
    rewards: Rewards = field(default_factory=Rewards)
    max_detections: int = 8
    images: tuple[str, ...] = ()
    truth: bool = False

    def __post_init__(self) -> None:
        check_kind("part", self.part, str)
        check_whole("n_parts", self.n_parts, 1, 8)
        check_number("slot_time", self.slot_time, 0.0, MOST_TIME)
        self._check_methods()
        check_name("estimator", self.estimator, ESTIMATORS)
        if self.networks is not None:
            check_kind("networks", self.networks, str)
            if self.estimator != LEARNED:
                raise EnvOptionError(f"expected no networks with the estimator {self.estimator}, got {self.networks!r}")
        check_name("speed", self.speed, PRESETS)
        check_kind("conditions", self.conditions, Conditions)
        check_kind("rewards", self.rewards, Rewards)
        check_whole("max_detections", self.max_detections, 1, MOST_DETECTIONS)
        check_names("images", self.images, IMAGES)
        check_kind("truth", self.truth, bool)

    def _check_methods(self) -> None:
        if isinstance(self.methods, str) or not isinstance(self.methods, tuple | list | Mapping) or not self.methods:
            raise EnvOptionError(f"expected methods to be a tuple of names or a mapping, got {shown(self.methods)}")
        if not isinstance(self.methods, Mapping):
            check_names("methods", self.methods, {**METHODS, **(NETWORK_METHODS if self.estimator == LEARNED else {})})
            return
        for name, method in self.methods.items():
            if not isinstance(name, str) or not callable(method):
                raise EnvOptionError(
                    f"expected methods by name, each a maskval.UncertaintyMethod that is called with estimates, "
                    f"got {shown(method)} for {shown(name)}"
                )
            needs_of(method)

    def make_methods(self) -> dict[str, UncertaintyMethod]:
        """The methods by name, new ones for those of the library; the controller logs the first one's u."""
        if isinstance(self.methods, Mapping):
            return dict(self.methods)
        return {name: (METHODS | NETWORK_METHODS)[name]() for name in self.methods}

    @property
    def camera_images(self) -> frozenset[Image]:
        """The images that the observation needs of the camera."""
        return frozenset(Image(name) for name in self.images if name != "masks")
