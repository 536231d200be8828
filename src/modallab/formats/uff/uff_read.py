"""Universal files: time records become blocks, FRFs an FRF matrix."""

from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.options import ImportOptions
from modallab.formats.uff.uff_frf import read_frf
from modallab.formats.uff.uff_functions import KINDS, UniversalFile, read_functions
from modallab.formats.uff.uff_time import read_blocks

_USED = (1, 4, 6)


def read_uff(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read the functions (dataset 58, text or binary) of a universal file.

    Raises:
        FormatError: no universal file, cut off or damaged.
        DataError: neither time records nor FRFs, or not those of the rig.
    """
    where = str(path)
    content = read_functions(path)
    blocks, notes = read_blocks(content, path, rig, options)
    frfs = read_frf(content, rig, where)
    if not blocks and not frfs:
        raise DataError(
            f"holds neither time records nor FRFs, only {_contents(content)}",
            where=where,
            remedy="export time records or FRFs as dataset 58",
        )
    skipped = [f for f in content.functions if f.kind not in _USED]
    left_out = (f"{path.name}: left out {_contents(content)}",) if skipped or content.others else ()
    remarks = (*notes, *left_out)
    return Campaign(rig, blocks, frfs, {"notes": "\n".join(remarks)} if remarks else {}, where)


def _contents(content: UniversalFile) -> str:
    functions = [KINDS.get(f.kind, f"function of type {f.kind}") for f in content.functions if f.kind not in _USED]
    return ", ".join(dict.fromkeys([*functions, *(f"dataset {kind}" for kind in content.others)])) or "no sets"
