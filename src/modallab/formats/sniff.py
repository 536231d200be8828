"""What kind a file is of: by its content first, by its ending where the content does not show it."""

from pathlib import Path
from typing import Literal

from modallab.core.errors import FormatError
from modallab.formats.campaign.campaign_hdf5 import CAMPAIGN_FILE
from modallab.formats.campaign.hdf5_access import is_hdf5
from modallab.formats.npy.npy import MAGIC as NPY_MAGIC
from modallab.formats.tdms.tdms_types import TAG as TDMS_TAG
from modallab.formats.uff.uff_functions import DELIMITER

Kind = Literal["campaign", "uff", "npy", "csv", "tdms", "sep005"]

_HEAD_BYTES = 4096
_CLAIMS = {
    ".h5": "HDF5 file",
    ".hdf5": "HDF5 file",
    ".npy": "NPY file",
    ".uff": "universal file: it does not begin with a line '    -1'",
    ".unv": "universal file: it does not begin with a line '    -1'",
    ".bunv": "universal file: it does not begin with a line '    -1'",
    ".tdms": "TDMS file",
    ".json": "JSON list of time series",
    ".uf": "universal file: it does not begin with a line '    -1'",
}
_TEXTS = {".csv", ".txt", ".tsv", ".dat", ".asc"}
_KINDS = "UFF 58 or 58b, NPY, CSV, TDMS, SEP005 in JSON, or a campaign in HDF5"


def sniff(path: Path) -> Kind:
    """The kind of a recording.

    Raises:
        FormatError: missing, empty, a folder without a campaign, or of no known kind.
    """
    where = str(path)
    if path.is_dir():
        if (path / CAMPAIGN_FILE).is_file():
            return "campaign"
        raise FormatError(
            f"is a folder, without {CAMPAIGN_FILE}", where=where, remedy="name the files in it, as folder/*.npy"
        )
    try:
        with path.open("rb") as source:
            head = source.read(_HEAD_BYTES)
    except OSError as error:
        raise FormatError(
            f"cannot be read: {error.strerror or error}", where=where, remedy="check the name of the file"
        ) from error
    if not head.strip():
        raise FormatError("is empty", where=where, remedy="copy the file again from where it was recorded")
    return _of_content(head, path)


def _of_content(head: bytes, path: Path) -> Kind:
    if is_hdf5(head):
        return "campaign"
    if head.startswith(NPY_MAGIC):
        return "npy"
    if head.startswith(TDMS_TAG):
        return "tdms"
    if head.lstrip().startswith(b"[") and path.suffix.lower() == ".json":
        return "sep005"
    if head.lstrip().splitlines()[0].strip() == DELIMITER:
        return "uff"
    ending = path.suffix.lower()
    if ending in _CLAIMS:
        raise FormatError(f"is no {_CLAIMS[ending]}", where=str(path), remedy=f"name a file of a known kind: {_KINDS}")
    if ending in _TEXTS or _is_text(head):
        return "csv"
    raise FormatError("is of no known kind", where=str(path), remedy=f"name a file of a known kind: {_KINDS}")


def _is_text(head: bytes) -> bool:
    return all(byte >= 32 or byte in b"\t\r\n\f" for byte in head)
