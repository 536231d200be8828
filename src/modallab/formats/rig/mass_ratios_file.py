"""The rigid-mass ratios of a campaign, in a file beside it: only ever added to."""

from pathlib import Path

import yaml
from pydantic import TypeAdapter, ValidationError

from modallab.core.errors import FormatError
from modallab.core.hardware import MassRatio
from modallab.formats.atomic import replacing

FILE = "mass_ratios.yaml"
_LIST: TypeAdapter[tuple[MassRatio, ...]] = TypeAdapter(tuple[MassRatio, ...])


def read_mass_ratios(folder: Path) -> tuple[MassRatio, ...]:
    """The ratios beside a campaign, in the order they were measured; none where there is no file.

    Raises:
        FormatError: the file is damaged.
    """
    path = folder / FILE
    if not path.is_file():
        return ()
    try:
        return _LIST.validate_python(tuple(yaml.safe_load(path.read_text(encoding="utf-8")) or ()))
    except (ValidationError, yaml.YAMLError, TypeError, UnicodeDecodeError) as error:
        raise FormatError(
            f"is no list of rigid-mass ratios: {str(error).partition(chr(10))[0]}",
            where=str(path),
            remedy="correct it, or move it away and measure again",
        ) from error


def add_mass_ratio(folder: Path, ratio: MassRatio) -> tuple[MassRatio, ...]:
    """Enter a ratio into the file of a folder; returns all.

    Raises:
        FormatError: the file is damaged.
        StorageError: it cannot be written.
    """
    ratios = (*read_mass_ratios(folder), ratio)
    with replacing(folder / FILE) as temporary:
        temporary.write_text(yaml.safe_dump(_LIST.dump_python(ratios, mode="json"), sort_keys=False), encoding="utf-8")
    return ratios
