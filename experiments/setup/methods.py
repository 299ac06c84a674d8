"""The methods under comparison: an uncertainty and the policy that uses it, by name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import maskval
from cell.interfaces import Policy
from cell.part import Part
from experiments.errors import UsageError
from experiments.setup.plugins import chosen, make_object
from experiments.setup.thresholds import Thresholds
from maskval import Ensemble, InvalidEstimatesError, RandomUncertainty, UncertaintyMethod, needs_of
from maskval.inputs.spelling import is_finite, shown
from policies import Always, ThresholdPolicy
from sim.networks.ground_truth import LatestTruth
from sim.networks.oracles import OracleMask, OracleMdd
from sim.networks.random_streams import Streams


@dataclass(frozen=True, slots=True)
class Context:
    """What an uncertainty may be made from; each experiment makes a new one.

    Attributes:
        part: the kind of part that is looked for.
        thresholds: of all methods.
        streams: the root of the experiment's random numbers.
        latest_truth: holds the truth; for the oracles only.
        source: name or file of the part, for commands that messages name; its name by default.
    """

    part: Part
    thresholds: Thresholds
    streams: Streams
    latest_truth: LatestTruth
    source: str | None = None


@dataclass(frozen=True, slots=True)
class Method:
    """The uncertainty and the policy of one experiment."""

    uncertainty: UncertaintyMethod
    policy: Policy


def _ensemble_add(context: Context) -> UncertaintyMethod:
    part, thresholds = context.part.name, context.thresholds
    if part not in thresholds.ensemble_add_minimum:
        raise UsageError(
            f"the thresholds {thresholds.source} have no ensemble_add_minimum_m.{part}; derive them with "
            f"graspcell dataset --objects {context.source or part} --methods maskval ensemble-add, "
            "and add --thresholds out/dataset/thresholds.toml"
        )
    return Ensemble("add", minimum=thresholds.ensemble_add_minimum[part])


def _random(context: Context) -> UncertaintyMethod:
    return RandomUncertainty(int(context.streams.generator(0, "random u").integers(2**63)))


def _regardless(make: Callable[[], UncertaintyMethod]) -> Callable[[Context], UncertaintyMethod]:
    return lambda _: make()


# Only Ensemble-ADD depends on the experiment: the thresholds say where its scale begins.
METHODS: dict[str, Callable[[Context], UncertaintyMethod]] = {
    **{name: _regardless(make) for name, make in maskval.METHODS.items()},
    "ensemble-add": _ensemble_add,
    "random": _random,
    "oracle-mask": lambda context: OracleMask(context.latest_truth),
    "oracle-mdd": lambda context: OracleMdd(context.latest_truth, context.part.symmetries),
    **{name: _regardless(make) for name, make in maskval.NETWORK_METHODS.items()},
}

NEEDS_NO_THRESHOLD = ("none",)


def named_methods(names: Sequence[str], *, networks: bool = False) -> tuple[str, ...]:
    """The names, with "all" for every method of `METHODS`.

    Args:
        names: what was asked for.
        networks: whether the estimators are trained networks; "all" has the methods that need such only then.
    """
    every = tuple(name for name in METHODS if networks or name not in maskval.NETWORK_METHODS)
    return every if list(names) == ["all"] else tuple(names)


def make_uncertainty(name: str, context: Context) -> UncertaintyMethod:
    """The uncertainty of this name, or an object of the class `package.module:Class`, made without arguments.

    Raises:
        UsageError: there is none, or it cannot be made.
    """
    make = chosen("--method", name, METHODS)
    if name in METHODS:
        return METHODS[name](context)
    made: UncertaintyMethod = make_object(name, make, ("__call__",))
    own_threshold(made, name)
    try:
        needs_of(made)
    except InvalidEstimatesError as error:
        raise UsageError(f"{name}: {error}") from error
    return made


def make_method(name: str, context: Context) -> Method:
    """The uncertainty of this name with its policy: the paper's two thresholds; "none" always grasps.

    Raises:
        UsageError: there is none, or no threshold for it.
    """
    uncertainty = make_uncertainty(name, context)
    if name in NEEDS_NO_THRESHOLD:
        return Method(uncertainty, Always())
    thresholds = context.thresholds
    u_grasp = thresholds.of(context.part.name, name, own_threshold(uncertainty, name), source=context.source)
    return Method(uncertainty, ThresholdPolicy(u_grasp, thresholds.refine))


def known_method(name: str, part: Part, thresholds: Thresholds, *, source: str | None = None) -> Method:
    """The method outside of an experiment, to check that it exists and what it needs; `source` as in `Context`.

    Raises:
        UsageError: see `make_method`.
    """
    return make_method(name, Context(part, thresholds, Streams(0, 0, part.name), LatestTruth(), source))


def own_threshold(uncertainty: UncertaintyMethod, name: str) -> float | None:
    """A method's own u_t,g, its attribute `u_grasp`; used if none was derived.

    Args:
        uncertainty: the method.
        name: its name, for the message.

    Raises:
        UsageError: it is no number from 0 to 1.
    """
    u_grasp = getattr(uncertainty, "u_grasp", None)
    if u_grasp is None:
        return None
    if not is_finite(u_grasp) or not 0.0 <= u_grasp <= 1.0:
        raise UsageError(f"{name}: expected its u_grasp to be a number in [0, 1], got {shown(u_grasp)}")
    return float(u_grasp)
