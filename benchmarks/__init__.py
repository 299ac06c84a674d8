"""Measured comparisons; each runs by hand with `python -m benchmarks.NAME`, none in the tests."""
