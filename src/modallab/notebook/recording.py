"""Recordings of a test, from wherever they come."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from modallab.core.array_checks import check_rate, check_signals
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError, RigError
from modallab.core.rig import Channel, Point, Rig
from modallab.core.units import SI_UNIT, Quantity
from modallab.formats.arrays.array_map import ArrayMap, map_of, read_map
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.format import sniff
from modallab.formats.importer import import_recordings
from modallab.formats.rig.rig_file import read_rig
from modallab.notebook.arguments import path_for
from modallab.notebook.display import DisplayedTable


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Recording:
    """Recordings of a bench.

    Attributes:
        campaign: the records and the rig, for all stages of modallab.
    """

    campaign: Campaign

    @property
    def rig(self) -> Rig:
        """Description of the bench."""
        return self.campaign.rig

    def table(self) -> DisplayedTable:
        """Table of the records; similar ones share a line."""
        found = Counter((b.test, len(b.channels), b.rate_hz, b.duration_s) for b in self.campaign.blocks)
        rows = [(str(n), test, str(c), f"{hz:g}", f"{s:g}") for (test, c, hz, s), n in found.items()]
        rows += [
            ("FRFs", "", f"{f.values.shape[0]} x {f.values.shape[1]}", "", f"{f.frequency_hz.size} lines")
            for f in self.campaign.frfs
        ]
        return DisplayedTable(("records", "test", "channels", "rate [Hz]", "length [s]"), rows, self.rig.name)

    def save(self, path: str | Path) -> Path:
        """Write the recordings as a campaign file (HDF5), completely or not at all; returns its path.

        Raises:
            StorageError: the file cannot be written, or its name has another ending.
        """
        path = path_for(path, (".h5", ".hdf5"))
        write_campaign(self.campaign, path)
        return path

    def __repr__(self) -> str:
        tests = Counter(b.test for b in self.campaign.blocks)
        held = [f"{n} {test} records" for test, n in tests.items()]
        held += [f"{len(self.campaign.frfs)} FRF matrices"] if self.campaign.frfs else []
        return f"<Recording of {self.rig.name!r}: {', '.join(held) or 'empty'}>"

    def _repr_html_(self) -> str:
        return self.table().html()


def load(
    path: str | Path | Sequence[str | Path],
    rig: str | Path | Rig | None = None,
    *,
    array_map: str | Path | Mapping[str, object] | None = None,
    **options: object,
) -> Recording:
    """Open recordings.

    Args:
        path: a campaign file, its folder, or files of any format that can be imported.
        rig: the rig file, instead of that inside or beside the recordings. By default a rig is made for foreign
            files that name their channels.
        array_map: map of the variables of a MATLAB file: a YAML file, or its content.
        options: facts missing in foreign files: test, rate_hz, drive_point, frequency_hz, window_s, variables,
            columns, channels, ignore, level, set_up, group, volts, as the reference of imports says.

    Raises:
        FormatError: no such file, or an unknown format.
        RigError: no rig, or an invalid rig.
        DataError: the records contain impossible values.
    """
    paths = _campaign_paths(path)
    for one in paths:
        _require_file(one)
    if not isinstance(rig, Rig | str | Path | None):
        raise RigError(f"{rig!r} is no rig", remedy="give the name of a rig file: rig='rig.yaml'")
    known = rig if isinstance(rig, Rig) or rig is None else read_rig(Path(rig))
    own = paths[0].is_dir() or sniff(paths[0]).name == "hdf5"
    if own and (known is None or (len(paths) == 1 and not options)):
        if len(paths) > 1:
            raise FormatError("several files need a rig", where=str(paths[0]), remedy="give rig='rig.yaml'")
        return Recording(read_campaign(paths[0], known))
    return Recording(import_recordings(paths, known, options | {"array_map": _array_map(array_map)}))


def _array_map(given: str | Path | Mapping[str, object] | None) -> ArrayMap | None:
    if given is None:
        return None
    return read_map(Path(given)) if isinstance(given, str | Path) else map_of(given, "array_map")


def _campaign_paths(path: object) -> list[Path]:
    listed = [path] if isinstance(path, str | Path) else path
    if not isinstance(listed, Sequence) or not all(isinstance(one, str | Path) for one in cast("list[object]", listed)):
        raise FormatError(f"{path!r} is no name of a file", remedy="give the path as text: ml.load('campaign.h5')")
    return [Path(one) for one in cast("list[str | Path]", listed)]


def _require_file(path: Path) -> None:
    if not path.exists():
        raise FormatError("does not exist", where=str(path), remedy=f"look for the file in {path.absolute().parent}")
    if path.suffix in (".json", ".html"):
        raise FormatError("is no recording", where=str(path), remedy="give a file of recordings, such as campaign.h5")


def responses(
    y: ArrayLike,
    rate_hz: float,
    points: Sequence[int] | None = None,
    names: Sequence[str] | None = None,
    quantity: Quantity = "acceleration",
) -> Recording:
    """Responses to an unmeasured random force, for `ml.identify`.

    Args:
        y: (outputs, samples) in SI, one record.
        rate_hz: sampling rate.
        points: number of the point of each response (default: 1, 2, ...).
        names: names of the responses (default: y1, y2, ...).
        quantity: acceleration, velocity or displacement.

    Raises:
        DataError: no record of real numbers, or another number of points or names.
    """
    samples = np.atleast_2d(np.asarray(y))
    if samples.dtype.kind in "iuf":
        samples = np.ascontiguousarray(samples, np.float64)
    at = tuple(range(1, len(samples) + 1)) if points is None else tuple(int(p) for p in points)
    called = tuple(f"y{p}" for p in at) if names is None else tuple(names)
    for what, given in (("points", at), ("names", called)):
        if len(given) != len(samples) or len(set(given)) < len(given):
            raise DataError(
                f"{what}={list(given)} for {len(samples)} responses",
                remedy=f"give {len(samples)} different {what}, in the order of y",
            )
    check_signals(samples, called, "y")
    channels = tuple(
        Channel(index=i, name=name, quantity=quantity, unit=SI_UNIT[quantity], point=point)
        for i, (name, point) in enumerate(zip(called, at, strict=True))
    )
    places = tuple(Point(id=p, x_m=float(p)) for p in sorted(at))
    rig = Rig(name="responses from arrays", model="unknown", points=places, channels=channels)
    block = Block(
        name="responses",
        test="random",
        order=0,
        rate_hz=check_rate(rate_hz, "y"),
        samples=samples,
        scale=np.ones(len(samples)),
        units=tuple(c.unit for c in channels),
        channels=called,
    )
    return Recording(Campaign(rig, (block,), source="arrays"))
