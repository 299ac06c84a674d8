"""Experiments in the simulated cell: the only place with a command line, files, seeds and printing."""
