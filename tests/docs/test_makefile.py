import re
from pathlib import Path

MAKEFILE = (Path(__file__).parents[2] / "Makefile").read_text(encoding="utf-8")


def test_every_target_that_is_no_file_has_a_rule_with_something_to_do() -> None:
    (listed,) = re.findall(r"^\.PHONY: (.*)$", MAKEFILE, re.MULTILINE)
    targets = listed.split()
    assert len(targets) >= 7
    without = [name for name in targets if not re.search(rf"^{name}:.*\n\t\S", MAKEFILE, re.MULTILINE)]
    assert without == []


def test_an_edit_of_any_compiled_kernel_compiles_all_of_them_anew() -> None:
    root = Path(__file__).parents[2]
    (watched,) = re.findall(r"^\$\(COMPILED\): \$\(READY\) \$\(wildcard (.*)\)$", MAKEFILE, re.MULTILINE)
    files = {path for pattern in watched.split() for path in root.glob(pattern)}
    kernels = [
        path for folder in ("maskval", "sim") for path in (root / folder).rglob("*.py") if "@jit" in path.read_text()
    ]
    assert len(kernels) >= 5
    assert [path for path in kernels if path not in files] == []
