import dataclasses
import importlib
import inspect
import pkgutil

import experiments
from experiments.dataset.coco import Annotations
from experiments.results.recorder import Recorder

GROWING = {Recorder, Annotations}  # what collects rows


def records() -> set[type]:
    """All dataclasses of the package."""
    names = [module.name for module in pkgutil.walk_packages(experiments.__path__, "experiments.")]
    assert len(names) > 50
    modules = [importlib.import_module(name) for name in names]
    classes = {one for module in modules for _, one in inspect.getmembers(module, inspect.isclass)}
    return {one for one in classes if dataclasses.is_dataclass(one) and one.__module__.startswith("experiments")}


def test_nobody_can_change_a_record() -> None:
    found = records()
    assert len(found) > 30
    assert {one for one in found if not one.__dataclass_params__.frozen} == GROWING  # type: ignore[attr-defined]
