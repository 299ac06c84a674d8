"""Which attempts failed, how uncertain the pose was said to be, and how wrong it was: from the logs of a run.

Run it with `python failed_attempts.py FOLDER`, the --out of `graspcell compare` or `graspcell run`.
"""

import sys
from pathlib import Path

import pyarrow.parquet as pq

from cell import Outcome


def table(folder, name):
    """The rows of one table of the logs, as dicts."""
    return pq.read_table(folder / f"{name}.parquet").to_pylist()


def main():
    """Prints a line for each attempt, failed ones marked."""
    folder = Path(sys.argv[1])
    keys = ("object", "method", "experiment", "frame", "detection")
    estimates = {tuple(row[key] for key in keys): row for row in table(folder, "estimates")}
    for attempt in table(folder, "attempts"):
        estimate = estimates[tuple(attempt[key] for key in keys)]
        error_m = estimate["true_mdd_m"]
        error = "no part" if error_m is None else f"{1000 * error_m:5.1f} mm"
        mark = "!" if Outcome(attempt["outcome"]).is_false_positive else " "
        print(
            f"{mark} {attempt['object']} × {attempt['method']}, experiment {attempt['experiment']}: "
            f"u = {attempt['u']:.3f}, true error {error}: {attempt['outcome']}"
        )


if __name__ == "__main__":
    main()
