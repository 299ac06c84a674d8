"""How Numba compiles the kernels. Its cache does not see an edit here: delete `__pycache__` after one."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.extending import intrinsic

P = ParamSpec("P")
T = TypeVar("T")


def jit(function: Callable[P, T]) -> Callable[P, T]:
    """The function, compiled at its first call and kept on disk; it runs without Python's lock, with NumPy's 1 / 0."""
    return cast(Callable[P, T], numba.njit(cache=True, nogil=True, error_model="numpy")(function))


def _count_bits(_typing_context: Any, _word: Any) -> Any:
    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return numba.types.uint64(numba.types.uint64), generate


# The processor's own instruction: how many bits of a uint64 are set.
popcount: Any = intrinsic(_count_bits)
