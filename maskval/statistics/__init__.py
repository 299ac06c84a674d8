"""Intervals of means, shares and clustered samples."""
