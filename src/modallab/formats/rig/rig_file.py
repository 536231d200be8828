"""The rig file: YAML to a validated `Rig`, and back."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import yaml
from pydantic import TypeAdapter, ValidationError

from modallab.core.errors import RigError
from modallab.core.field_errors import FieldProblem
from modallab.core.hardware import Certificate
from modallab.core.rig import Rig
from modallab.formats.atomic import replacing
from modallab.formats.rig.rig_yaml import load_yaml, rig_problems

_RESULTS = {"models": "holds modal models", "verdict": "is the diagnosis of a gap"}
"""A field of a file that modallab writes -> what it is, where somebody names it as a rig file."""
_HDF5 = b"\x89HDF\r\n\x1a\n"
_FIELD = "sensors"
_LIST: TypeAdapter[list[Certificate]] = TypeAdapter(list[Certificate])


def read_rig(path: Path) -> Rig:
    """Read a rig file.

    Raises:
        RigError: the file is missing or no YAML, or one message with every error of the rig: field, value, what is
            allowed.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        with path.open("rb") as file:
            hdf5 = file.read(8) == _HDF5
        found = "is not text in UTF-8 but HDF5, as campaigns are" if hdf5 else "is not text in UTF-8"
        remedy = "name the YAML file that describes the rig" if hdf5 else "save the rig file as UTF-8 text"
        raise RigError(found, where=str(path), remedy=remedy) from error
    except OSError as error:
        found = "is a folder" if path.is_dir() else f"cannot be read: {error.strerror or error}"
        raise RigError(found, where=str(path), remedy="name the YAML file that describes the rig") from error
    return parse_rig(text, str(path), path.parent)


def parse_rig(text: str, where: str, folder: Path | None = None) -> Rig:
    """Read a rig from the text of its file; `where` names it in messages, files it names lie in `folder`.

    Raises:
        RigError: as for `read_rig`.
    """
    try:
        content, problems = load_yaml(text)
    except Exception as error:  # PyYAML lets AttributeError, OverflowError and others through on odd text.
        raise RigError(f"is not YAML: {_syntax(error)}", where=where, remedy="correct the syntax there") from error
    if not isinstance(content, Mapping):
        found = "is empty" if content is None else f"holds {type(content).__name__} {str(content)[:40]!r}, not fields"
        raise RigError(found, where=where, remedy="write the rig as fields, each as name: value")
    fields = cast("Mapping[str, object]", content)
    for field, what in _RESULTS.items():
        if field in fields and "channels" not in fields:
            raise RigError(f"{what}, not a rig file", where=where, remedy="name the YAML file that describes the rig")
    if "kind" in fields and "channels" not in fields:
        found = f"is the plan of a test (kind: {fields['kind']}), not a rig file"
        raise RigError(found, where=where, remedy="name the rig file here; a plan is given where a plan is asked for")
    if folder is not None:
        fields = _with_certificates(fields, folder, where)
    try:
        rig = Rig.model_validate(fields)
    except ValidationError as error:
        raise _rejection([*problems, *rig_problems(fields, error)], where) from error
    if problems:
        raise _rejection(problems, where)
    return rig


def dump_rig(rig: Rig) -> str:
    """The text of a rig file, from which `parse_rig` gets an equal rig."""
    content = rig.model_dump(mode="json", exclude_none=True)
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True)


def write_rig(rig: Rig, path: Path) -> None:
    """Write a rig file, whole or not at all.

    Raises:
        StorageError: the file cannot be written.
    """
    with replacing(Path(path)) as temporary:
        temporary.write_text(dump_rig(rig), encoding="utf-8")


def _rejection(problems: list[FieldProblem], where: str) -> RigError:
    count = "1 field is wrong" if len(problems) == 1 else f"{len(problems)} fields are wrong"
    lines = "".join(f"\n  {problem}" for problem in problems)
    return RigError(f"{count}:{lines}", where=where, remedy="correct the fields above; docs/reference/rig-file.md")


def _syntax(error: Exception) -> str:
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        mark = error.problem_mark
        return f"line {mark.line + 1}, column {mark.column + 1}: {error.problem or error.context}"
    return "nested too deeply" if isinstance(error, RecursionError) else str(error).partition("\n")[0]


def _with_certificates(content: Mapping[str, object], folder: Path, where: str) -> Mapping[str, object]:
    """The fields of a rig file with the certificates of the file it names, put to the channels by serial.

    A channel that has a certificate of its own keeps it; of several certificates of a sensor the latest counts.

    Raises:
        RigError: the file is missing or not valid.
    """
    if _FIELD not in content:
        return content
    name = content[_FIELD]
    if not isinstance(name, str) or not name:
        raise RigError(f"{_FIELD}: found {name!r}", where=where, remedy="name a file, as sensors: sensors.yaml")
    latest: dict[str, Certificate] = {}
    for certificate in sorted(_read_sensors(folder / name), key=lambda one: one.date):
        latest[certificate.serial] = certificate
    rest = {key: value for key, value in content.items() if key != _FIELD}
    channels = content.get("channels")
    if isinstance(channels, Sequence) and not isinstance(channels, str):
        rest["channels"] = [_certified(channel, latest) for channel in cast("Sequence[object]", channels)]
    return rest


def _read_sensors(path: Path) -> list[Certificate]:
    """The certificates of a file, a YAML list.

    Raises:
        RigError: it is missing, no YAML, or a certificate is not valid.
    """
    try:
        content, problems = load_yaml(path.read_text(encoding="utf-8-sig"))
        found = _LIST.validate_python(content)
    except OSError as error:
        raise RigError(
            f"cannot be read: {error.strerror or error}", where=str(path), remedy="see field sensors"
        ) from error
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise RigError(
            f"{place}: {first['msg']}; found {first['input']!r}",
            where=str(path),
            remedy="correct this field; docs/reference/rig-file.md",
        ) from error
    if problems:
        raise RigError("; ".join(str(problem) for problem in problems), where=str(path), remedy="correct these fields")
    return found


def _certified(channel: object, latest: Mapping[str, Certificate]) -> object:
    if not isinstance(channel, Mapping):
        return channel
    fields = cast("Mapping[str, object]", channel)
    certificate = latest.get(str(fields.get("serial", "")))
    if certificate is None or "certificate" in fields:
        return fields
    return {**fields, "certificate": certificate.model_dump(mode="json", exclude_none=True)}
