"""The command line as a person meets it, in this process."""

from dataclasses import dataclass

import pytest

from experiments.cli import main


@dataclass(frozen=True)
class Told:
    """What a command came to: exit code, what it printed, and what a terminal shows of its errors."""

    code: int
    out: str
    err: str


def command(capsys: pytest.CaptureFixture[str], *arguments: object) -> Told:
    """Runs `graspcell` with the arguments; a line that a carriage return overwrites is not shown."""
    capsys.readouterr()
    with pytest.raises(SystemExit) as end:
        main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    shown = [line.split("\r")[-1].rstrip() for line in printed.err.split("\n")]
    assert isinstance(end.value.code, int)
    return Told(end.value.code, printed.out, "\n".join(shown))


def overriding(*arguments: object) -> list[str]:
    """The arguments without those options, and their values, that others of the same name follow."""
    groups: list[list[str]] = [[]]
    for argument in map(str, arguments):
        groups += [[]] if argument.startswith("--") else []
        groups[-1].append(argument)
    last = {group[0]: index for index, group in enumerate(groups) if group}
    return [word for index, group in enumerate(groups) if group and last[group[0]] == index for word in group]
