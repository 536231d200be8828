"""The rig file: YAML to a validated `Rig`, and back."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from modallab.errors import RigError
from modallab.schema.rig import Rig


def read_rig(path: Path) -> Rig:
    """Read a rig file.

    Raises:
        RigError: one message with every error of the file.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise RigError(f"cannot be read: {error.strerror}", where=str(path), remedy="name a rig file") from error
    return parse_rig(text, str(path))


def parse_rig(text: str, where: str) -> Rig:
    """Read a rig from the text of its file; `where` names it in messages."""
    try:
        content: Any = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise RigError(f"is not YAML: {error}", where=where, remedy="mend the syntax") from error
    try:
        return Rig.model_validate(content)
    except ValidationError as error:
        raise RigError(str(error), where=where, remedy="mend the fields above") from error
