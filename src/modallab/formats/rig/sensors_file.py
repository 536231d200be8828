"""A file of sensors, one certificate each, that many rig files name: `sensors: sensors.yaml`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from pydantic import TypeAdapter, ValidationError

from modallab.core.errors import RigError
from modallab.core.metrology import Certificate
from modallab.formats.rig.rig_yaml import load_yaml

FIELD = "sensors"
_LIST: TypeAdapter[list[Certificate]] = TypeAdapter(list[Certificate])


def with_certificates(content: Mapping[str, object], folder: Path, where: str) -> Mapping[str, object]:
    """The fields of a rig file with the certificates of the file it names, put to the channels by serial.

    A channel that has a certificate of its own keeps it; of several certificates of a sensor the latest counts.

    Raises:
        RigError: the file is missing or not valid.
    """
    if FIELD not in content:
        return content
    name = content[FIELD]
    if not isinstance(name, str) or not name:
        raise RigError(f"{FIELD}: found {name!r}", where=where, remedy="name a file, as sensors: sensors.yaml")
    latest: dict[str, Certificate] = {}
    for certificate in sorted(read_sensors(folder / name), key=lambda one: one.date):
        latest[certificate.serial] = certificate
    rest = {key: value for key, value in content.items() if key != FIELD}
    channels = content.get("channels")
    if isinstance(channels, Sequence) and not isinstance(channels, str):
        rest["channels"] = [_certified(channel, latest) for channel in cast("Sequence[object]", channels)]
    return rest


def read_sensors(path: Path) -> list[Certificate]:
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
