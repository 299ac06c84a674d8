"""Experiments as units that survive: each is written once under a name that everything goes into that decides it."""
