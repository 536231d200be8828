"""Campaign files: HDF5 of version 1 (int16 counts, one scale) or 2 (what a device delivers)."""

import io
from dataclasses import replace
from pathlib import Path

import h5py

from modallab.core.block import Campaign
from modallab.core.errors import FormatError, RigError
from modallab.core.hardware import judge_mass_ratios
from modallab.core.rig import Rig
from modallab.core.versions import CAMPAIGN_INT16, CAMPAIGN_NATIVE
from modallab.formats.atomic import replacing
from modallab.formats.campaign import CAMPAIGN_FILE
from modallab.formats.campaign import hdf5_version_1 as hdf5_counts
from modallab.formats.campaign import hdf5_version_2 as hdf5_native
from modallab.formats.campaign.hdf5_access import COPY_AGAIN, TypedAttributes, open_hdf5
from modallab.formats.check_campaign import check_recordings, check_structure
from modallab.formats.options import ImportOptions
from modallab.formats.rig.mass_ratios_file import read_mass_ratios
from modallab.formats.rig.rig_file import parse_rig, read_rig

RIG_FILE = "rig.yaml"
RIGID_MASS = "rigid-mass ratio"


def read_campaign(path: Path, rig: Rig | None = None, *, check: bool = True) -> Campaign:
    """Read a campaign: a folder with `campaign.h5`, or the HDF5 file itself.

    The rig is the one given, else the one in the file, else `rig.yaml` beside it.

    Args:
        path: folder or file.
        rig: the rig to believe, whatever stands in or beside the file.
        check: reject records that no measurement can hold; without it, only a file that is not whole is rejected.

    Raises:
        FormatError: missing, no campaign, cut off, damaged, or of a newer version.
        RigError: there is no rig, or it is not valid.
        DataError: the records are not those of the rig, or hold NaN, dead channels and the like.
    """
    file = campaign_file(Path(path))
    where = str(file)
    with open_hdf5(file) as source:
        version = _version(source, where)
        text = hdf5_native.read_rig_text(source, where)
        rig = rig or (parse_rig(text, f"{where}, rig") if text else _rig_beside(file))
        if version == CAMPAIGN_INT16:
            campaign = Campaign(rig, hdf5_counts.read_blocks(source, rig, where), source=str(path))
        else:
            campaign = hdf5_native.read_content(source, rig, where, str(path))
    ratios = judge_mass_ratios(read_mass_ratios(file.parent))
    if ratios:
        # Measured after the file was written, as often as before it.
        summary = "; ".join(f"{'good' if one.within else 'bad'}: {one.what}" for one in ratios)
        campaign = replace(campaign, provenance=campaign.provenance | {RIGID_MASS: summary})
    check_structure(campaign)
    if check:
        check_recordings(campaign)
    return campaign


def import_campaign(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """A campaign file on a rig; records that name no drive point get that of the options.

    Raises:
        FormatError, DataError: as `read_campaign`.
    """
    campaign, point = read_campaign(path, rig), options.drive_point
    blocks = (replace(b, drive_point=point) if b.drive_point is None else b for b in campaign.blocks)
    return replace(campaign, blocks=tuple(blocks))


def write_campaign(campaign: Campaign, path: Path) -> None:
    """Write a campaign as one file of version 2: whole, or not at all.

    Samples are written as they are, dead channels and all: what a device delivered is never edited.

    Raises:
        DataError: the parts of the campaign do not belong together.
        StorageError: the file cannot be written.
        DiskFullError: the disk is full.
    """
    check_structure(campaign)
    # HDF5 crashes on a full disk, so it writes to memory, and the bytes go to the disk from there.
    image = io.BytesIO()
    with h5py.File(image, "w", libver=("v110", "v110")) as target:
        hdf5_native.write_content(target, campaign)
    with replacing(Path(path)) as temporary:
        temporary.write_bytes(image.getbuffer())


def campaign_file(path: Path) -> Path:
    """The HDF5 file of a campaign, given as a file or a folder.

    Raises:
        FormatError: the folder holds none.
    """
    if not path.is_dir():
        return path
    file = path / CAMPAIGN_FILE
    if not file.is_file():
        raise FormatError(
            f"is a folder without {CAMPAIGN_FILE}",
            where=str(path),
            remedy=f"name a file, or a folder with {CAMPAIGN_FILE}",
        )
    return file


def _version(source: h5py.File, where: str) -> int:
    facts = TypedAttributes.of(source, where)
    if not facts.has("format_version"):
        if not hdf5_counts.is_counts(source):
            raise hdf5_counts.reject_foreign(where)
        return CAMPAIGN_INT16
    version = facts.whole("format_version")
    if version > CAMPAIGN_NATIVE:
        raise FormatError(
            f"is a campaign of format version {version}; this modallab reads up to {CAMPAIGN_NATIVE}",
            where=where,
            remedy="update modallab",
        )
    if version not in (CAMPAIGN_INT16, CAMPAIGN_NATIVE):
        raise FormatError(f"claims format version {version}", where=where, remedy=COPY_AGAIN)
    return version


def _rig_beside(file: Path) -> Rig:
    beside = file.parent / RIG_FILE
    if not beside.is_file():
        raise RigError(
            f"no rig: none in the file, and no {RIG_FILE} beside it",
            where=str(file),
            remedy=f"give the rig with --rig, or put {RIG_FILE} beside the campaign",
        )
    return read_rig(beside)
