"""What format a recording is of: by its content first, by its ending where the content does not tell."""

from pathlib import Path

from modallab.core.errors import FormatError
from modallab.formats.format import Format, readers

_HEAD_BYTES = 4096


def sniff(path: Path) -> Format:
    """The format of a recording.

    Raises:
        FormatError: missing, empty, a folder without a campaign, or of no known format.
    """
    if path.is_dir():
        return _of_folder(path)
    try:
        with path.open("rb") as source:
            head = source.read(_HEAD_BYTES)
    except OSError as error:
        raise FormatError(
            f"cannot be read: {error.strerror or error}", where=str(path), remedy="check the name of the file"
        ) from error
    if not head.strip():
        raise FormatError("is empty", where=str(path), remedy="copy the file again from where it was recorded")
    return _of_content(head, path)


def _of_folder(path: Path) -> Format:
    held = [f for f in readers() if f.inside]
    for known in held:
        if (path / known.inside).is_file():
            return known
    names = " or ".join(f.inside for f in held)
    raise FormatError(f"is a folder, without {names}", where=str(path), remedy="name the files in it, as folder/*.npy")


def _of_content(head: bytes, path: Path) -> Format:
    known = readers()
    kinds = f"name a file of a known kind: {', '.join(f.title for f in sorted(known, key=lambda f: f.name))}"
    for certain in (True, False):
        for one in known:
            if one.certain == certain and one.fits is not None and one.fits(head, path):
                return one
        for one in known:
            if one.certain == certain and path.suffix.lower() in one.endings:
                raise FormatError(f"is no {one.is_no}", where=str(path), remedy=kinds)
    raise FormatError("is of no known kind", where=str(path), remedy=kinds)
