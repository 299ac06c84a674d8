"""Runs written in the formats of others: BOP's and LeRobot's."""
