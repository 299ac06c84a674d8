"""How Numba compiles the kernels. Its cache does not see an edit here: delete `__pycache__` after one."""

import logging
from collections.abc import Callable
from functools import cache
from typing import Any, ParamSpec, TypeVar, cast

import numba
from llvmlite import ir
from numba.extending import intrinsic

P = ParamSpec("P")
T = TypeVar("T")


def jit(function: Callable[P, T]) -> Callable[P, T]:
    """The function, compiled at its first call and kept on disk; it runs without Python's lock, with NumPy's 1 / 0.

    Where no folder can be written, it is compiled for this process only.
    """
    try:
        compiled = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # Numba's, about each function
        _say_that_nothing_is_kept()
        compiled = numba.njit(nogil=True, error_model="numpy")(function)
    return cast(Callable[P, T], compiled)


@cache
def _say_that_nothing_is_kept() -> None:
    """One line for each process, on the standard error unless the program handles its log otherwise."""
    logging.getLogger(__name__).warning(
        "Numba has no folder to keep compiled kernels in, so this process compiles them, for some 20 s: "
        "export NUMBA_CACHE_DIR=a folder that can be written"
    )


def _count_bits(_typing_context: Any, _word: Any) -> Any:
    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return numba.types.uint64(numba.types.uint64), generate


def _above(_typing_context: Any, pixels: Any, _first: Any, _least: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, first, least = arguments
        bytes_64 = ir.VectorType(ir.IntType(8), 64)
        data = context.make_array(signature.args[0])(context, builder, array).data
        address = builder.bitcast(builder.gep(data, [first]), bytes_64.as_pointer())
        one = builder.insert_element(ir.Constant(bytes_64, ir.Undefined), least, ir.IntType(32)(0))
        every = builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), 64), [0] * 64))
        above = builder.icmp_unsigned(">", builder.load(address, align=1), every)
        return builder.bitcast(above, ir.IntType(64))

    return numba.types.uint64(pixels, numba.types.int64, numba.types.uint8), generate


# The processor's own instruction: how many bits of a uint64 are set.
popcount: Any = intrinsic(_count_bits)
# above(pixels, i, least): bit j says whether byte i + j of a contiguous uint8 array is greater; nothing is checked.
above: Any = intrinsic(_above)
