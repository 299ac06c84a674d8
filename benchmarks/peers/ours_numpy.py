"""This library without compilation."""

from benchmarks.peers import ours


class Contender(ours.Contender):
    """The same kernel in NumPy."""

    implementation = "numpy"
