"""What was asked for of a run: the file that its folder begins with."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from experiments.errors import UsageError
from experiments.units.identity import Description
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text

FORMAT = 1
ASKED = "run.json"


@dataclass(frozen=True, slots=True)
class Asked:
    """A cell of the table that was asked for.

    Attributes:
        description: of its experiment 0; the others differ in number and noise alone.
        experiments: how many were asked for.
        options: of the command that asked last, as JSON has them, without those that change no result.
    """

    description: Description
    experiments: int
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def of(self) -> dict[str, str]:
        """Object, method and policy."""
        found: dict[str, str] = self.description["of"]
        return found


def read_asked(folder: Path) -> tuple[list[Asked], dict[str, Any]]:
    """The cells that were asked for and the options of the command that asked last; none where there is no such file.

    Raises:
        UsageError: the file cannot be read, or is damaged.
    """
    file = folder / ASKED
    if not file.exists():
        return [], {}
    try:
        content = json.loads(read_input_text(file))
        form = content["format"]
        cells = [Asked(**one) for one in content["cells"]] if form == FORMAT else []
        options = content["options"]
    except InvalidFileError as error:
        raise UsageError(str(error)) from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise UsageError(
            f"{file} is damaged ({type(error).__name__}: {error}): expected what compare writes"
        ) from error
    if form != FORMAT:
        raise UsageError(f"{file}: expected format {FORMAT}, got {form}")
    return cells, options
