"""What must hold of the observations of both learning environments."""

from typing import Any

import numpy as np
import pytest

from maskval import METHODS

CERTAIN = 0.05  # exact poses, but masks of whole pixels: outlines and silhouettes agree to a pixel, u is not quite 0


def assert_every_method_judges_exact_estimates(observation: dict[str, Any]) -> None:
    """The first picture that shows a part, seen by exact networks; its u by what each method is defined as."""
    count = int(observation["valid"].sum())
    assert count >= 1
    u = {name: observation[f"u_{name}"][:count] for name in METHODS}
    assert not any(observation[f"u_{name}"][count:].any() for name in METHODS)
    assert u.pop("score") == pytest.approx(1.0 - observation["score"][:count])
    assert (u.pop("temporal") == 1.0).all()  # no other view speaks for the pose yet
    for name in ("none", "ensemble-add", "ensemble-mdd", "ensemble-translation", "ensemble-rotation"):
        assert (u.pop(name) == 0.0).all()
    assert u.pop("maskval-ensemble") == pytest.approx(u["maskval"], abs=1e-6)  # the ensemble's certainty is 1
    whole = observation["visibility"][:count] == 1.0
    assert whole.any()
    assert set(u) == {"maskval", "maskval-no-visibility", "contour", "depth"}
    for values in u.values():
        assert (values[whole] < CERTAIN).all()
        assert np.isfinite(values).all()
