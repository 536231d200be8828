"""What a format of recordings declares of itself, which formats there are, and of which one a recording is.

Each module of `modallab.formats.known` is one format. Its name is that of the file. The content of a recording tells
its format; where it does not, its ending does.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from modallab.core.discovery import declaration_in_module, declared_names
from modallab.core.errors import ConfigurationError, DataError, FormatError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


Part = Literal["records", "FRFs", "modes"]
Option = Literal[
    "test", "rate_hz", "drive_point", "volts", "frequency_hz", "window_s", "variables", "array_map", "group", "columns"
]

PACKAGE = "modallab.formats.known"
"""Where they are declared, one module each."""
_HEAD_BYTES = 4096
_OTHERS = {b"\x1f\x8b": "a file compressed by gzip", b"BZh": "a file compressed by bzip2"}
_OTHERS |= {b"PK\x03\x04": "a ZIP archive or a workbook", b"{": "a JSON object, and no list of SEP005"}
_OTHERS |= {b"\xd0\xcf\x11\xe0": "a compound document, as of Excel before 2007 or a scanning vibrometer"}
_OTHERS |= {b"PAR1": "a Parquet file", b"ARROW1": "a Feather file", b"FEA1": "a Feather file", b"SQLite": "a database"}
_OTHERS |= {b"MDF  ": "an MDF file", b"|CF,": "an imc FAMOS file", b"start of data": "an HDF file of HEAD acoustics"}
_OTHERS |= {b"$TITLE": "a punch file of Nastran", b"fLaC": "a FLAC file", b"riff": "a Wave64 file"}
_OTHERS |= {b"DIAEXTENDED": "a header of DIAdem, whose numbers stand in another file", b"IGOR": "an Igor text file"}
"""How files of other kinds begin that people have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format of recordings: a reader, a writer, or both.

    Attributes:
        name: that of its file; the command line calls it so.
        title: as a sentence names it, such as "UFF 58 or 58b".
        description: what such a file is, in one line.
        endings: of its files, in lower case, with the dot.
        is_no: what a file with such an ending is said not to be if its content is of another kind.
        holds: what it has a place for.
        several_forces: whether it says of a record which of several shakers drove.
        asks: what the user must say where a file does not, as fields of `ImportOptions`.
        priority: formats are tried in this order, the smallest first; no two have the same.
        certain: whether the content alone tells the format. One that is not certain is tried after all that are, and
            never for a file whose ending is that of another format.
        fits: whether a file is of this format, by its first 4096 bytes and its name.
        inside: the file by which a folder is taken for one of this format; "" if none is.
        read: a campaign of one file, on a rig, with what the user says of it.
        draft: the rig that a file was made on, as far as the file says; None if such files say nothing of it.
        write: a campaign into a file or folder; where it holds modes, also the models identified from the campaign.
    """

    name: str = ""
    title: str = ""
    description: str = ""
    endings: tuple[str, ...] = ()
    is_no: str = ""
    holds: tuple[Part, ...] = ()
    several_forces: bool = False
    asks: tuple[Option, ...] = ()
    priority: int = 0
    certain: bool = True
    fits: Callable[[bytes, Path], bool] | None = None
    inside: str = ""
    read: Callable[[Path, Rig, ImportOptions], Campaign] | None = None
    draft: Callable[[Path, ImportOptions], Rig] | None = None
    write: Callable[..., None] | None = None

    def __post_init__(self) -> None:
        """Reject a declaration that lacks something.

        Raises:
            ConfigurationError: says what is missing.
        """
        missing = [n for n in ("name", "title", "description", "is_no") if not getattr(self, n).strip()]
        missing += ["what it holds"] if not self.holds else []
        missing += ["endings, each in lower case with its dot"] if not _endings(self.endings) else []
        missing += ["a reader or a writer"] if self.read is None and self.write is None else []
        if (self.read is None) != (self.fits is None) or (self.read is not None and self.priority < 1):
            missing.append("a reader together with what fits it, and a priority from 1 on")
        if missing:
            raise ConfigurationError(
                f"the format {self.name!r} does not declare {', '.join(missing)}",
                remedy="complete its declaration; modallab.formats.format.Format says what each part is",
            )


def deferred(place: str) -> Callable[..., Any]:
    """A function of `modallab.formats`, as "module:name", whose module is imported when it is first called."""
    module, _, name = place.partition(":")

    def call(*arguments: Any) -> Any:
        return getattr(import_module(f"modallab.formats.{module}"), name)(*arguments)

    return call


def all_formats() -> tuple[Format, ...]:
    """The formats there are, by name.

    Raises:
        ConfigurationError: a file declares nothing, or not all.
    """
    return tuple(declaration_in_module(PACKAGE, name, "FORMAT", Format) for name in declared_names(PACKAGE))


def readers() -> tuple[Format, ...]:
    """The formats that can be read, in the order in which they are tried."""
    return tuple(sorted((f for f in all_formats() if f.read is not None), key=lambda f: (f.priority, f.name)))


def writers() -> tuple[Format, ...]:
    """The formats that can be written, by name."""
    return tuple(f for f in all_formats() if f.write is not None)


def find_writer(name: str) -> Format:
    """The format of this name.

    Raises:
        DataError: there is none, or it is only read; names those that are written.
    """
    found = {f.name: f for f in writers()}
    if name not in found:
        raise DataError(f"{name!r} is no format to write", remedy=f"ask for one of {', '.join(found)}")
    return found[name]


def _endings(endings: tuple[str, ...]) -> bool:
    return bool(endings) and all(e.startswith(".") and e == e.lower() and len(e) > 1 for e in endings)


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
        if other := next((what for mark, what in _OTHERS.items() if head.startswith(mark)), ""):
            remedy = f"unpack it or save it as CSV; else {kinds}"
            raise FormatError(f"is {other}, which is not read here", where=str(path), remedy=remedy)
        for one in known:
            if one.certain == certain and path.suffix.lower() in one.endings:
                raise FormatError(f"is no {one.is_no}", where=str(path), remedy=kinds)
    raise FormatError("is of no known kind", where=str(path), remedy=kinds)
