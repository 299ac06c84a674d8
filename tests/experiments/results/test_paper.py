from experiments.results.paper import ROBOT_TABLE

# Typed from the paper's table of the robot experiments, in per cent.
PRINTED = """
antenna  none          90.0   82.5
antenna  ensemble-add  96.0   50.0
antenna  maskval       97.5  100.0
handle   none          61.4   50.0
handle   ensemble-add 100.0   70.0
handle   maskval      100.0   72.5
"""


def test_the_six_cells_are_those_of_the_paper() -> None:
    printed = [line.split() for line in PRINTED.strip().splitlines()]
    assert len(printed) == 6
    assert {key: (round(100 * ap, 6), round(100 * ar, 6)) for key, (ap, ar) in ROBOT_TABLE.items()} == {
        (part, method): (float(ap), float(ar)) for part, method, ap, ar in printed
    }
