"""What a robot without uncertainty quantification did with a part: the paper's figures, or those of a file."""

import tomllib
from pathlib import Path

from experiments.errors import UsageError
from experiments.results.paper import ROBOT_TABLE
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text
from sim.errors import SimError
from sim.model.parts import load_part
from sim.networks.noise_model import load_noise

_FORM = "expected two lines, ap = A and ar = R, each in 0..1"


def robot_targets(part: str, file: Path | None) -> tuple[float, float]:
    """AP and AR to fit the gap to.

    Args:
        part: name or TOML file of the part.
        file: TOML with ap and ar; None for the paper's.

    Raises:
        UsageError: the part or the file does not exist or is malformed, or the paper has no figures of the part.
    """
    if file is None:
        names = tuple(dict.fromkeys(name for name, _ in ROBOT_TABLE))
        if part not in names:
            raise UsageError(
                f"the paper has no figures of {part!r}: expected one of {', '.join(names)}, or a part file with "
                f"what your robot did: graspcell gap --part FILE.toml --targets TARGETS.toml; {_FORM}"
            )
        return ROBOT_TABLE[part, "none"]
    try:
        load_noise(load_part(part).noise)
        table = tomllib.loads(read_input_text(file))
    except SimError as error:
        raise UsageError(str(error)) from error
    except InvalidFileError as error:
        raise UsageError(f"targets file {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"targets {file}: no TOML: {error}; {_FORM}") from error
    if set(table) != {"ap", "ar"} or not all(_is_share(value) for value in table.values()):
        raise UsageError(f"targets {file}: {_FORM}, got {table}")
    return float(table["ap"]), float(table["ar"])


def _is_share(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1
