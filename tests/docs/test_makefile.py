import re
from pathlib import Path

MAKEFILE = (Path(__file__).parents[2] / "Makefile").read_text(encoding="utf-8")


def test_every_target_that_is_no_file_has_a_rule_with_something_to_do() -> None:
    (listed,) = re.findall(r"^\.PHONY: (.*)$", MAKEFILE, re.MULTILINE)
    targets = listed.split()
    assert len(targets) >= 7
    without = [name for name in targets if not re.search(rf"^{name}:.*\n\t\S", MAKEFILE, re.MULTILINE)]
    assert without == []
