"""Faults put into real records: is each named by channel and time, and do the modes survive?

    python benchmarks/identification/faulty_samples.py FOLDER --faults 60 --seed 1 [--modes 10] [--csv FILE]

FOLDER holds hammer_5hits (five hits, one accelerometer) and uff/MPSTD*.uff (four accelerations), as pyFRF and pyuff
publish them. Each draw spoils one channel of one record, of most or of all, as the chain of a bench does, from a random
time on. Named: what the import or the sound part of the records says holds channel and time. Modes, of the first draws
of hits: those of the sound records, how many of them within three of their sigmas, and none beside.
"""

import argparse
import csv
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.check_campaign import check_recordings
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.options import ImportOptions
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.response_only import identify_chosen
from modallab.pipelines.undamaged_records import undamaged_records

Real = NDArray[np.float64]
SAME, SIGMAS, NEAR = 0.005, 3.0, 0.02
"""A mode is the same within SAME, and as it was within SIGMAS; a time is named within NEAR of the record."""

HEAD = ("number", "set", "kind", "channel", "records", "first_record", "first_s", "named", "modes", "kept", "others",
        "within", "said")  # fmt: skip


def flat_tops(row: Real, first: int, rng: np.random.Generator) -> Real:
    top = rng.uniform(0.3, 0.8) * np.abs(row).max()
    return np.clip(row, -top, top)


def held(row: Real, first: int, rng: np.random.Generator) -> Real:
    """Each value stands for several samples from some time on."""
    every, out = int(rng.integers(3, 12)), row.copy()
    out[first:] = np.repeat(row[first::every], every)[: len(row) - first]
    return out


def dropped(row: Real, first: int, rng: np.random.Generator) -> Real:
    out = row.copy()
    out[first : first + int(rng.uniform(0.002, 0.05) * len(row))] = 0.0
    return out


def dead(row: Real, first: int, rng: np.random.Generator) -> Real:
    return np.full_like(row, rng.choice([0.0, rng.normal() * np.abs(row).max()]))


def saturated(row: Real, first: int, rng: np.random.Generator) -> Real:
    """At full scale from some time on."""
    out = row.copy()
    out[first:] = rng.choice([-1, 1]) * 1.1 * np.abs(row).max()
    return out


def drifting(row: Real, first: int, rng: np.random.Generator) -> Real:
    """A zero that goes away after a shock, and comes back slowly."""
    out, t = row.copy(), np.arange(len(row) - first) / len(row)
    out[first:] += rng.choice([-1, 1]) * rng.uniform(1, 3) * np.abs(row).max() * np.exp(-t / rng.uniform(0.1, 0.6))
    return out


def damaged(row: Real, first: int, rng: np.random.Generator) -> Real:
    out = row.copy()
    out[first] = rng.choice([1e200, -3e35, 1e9 * np.abs(row).max()])
    return out


KINDS: tuple[Callable[[Real, int, np.random.Generator], Real], ...] = (
    flat_tops, held, dropped, dead, saturated, drifting, damaged
)  # fmt: skip


def hammer(folder: Path) -> tuple[Campaign, IdentificationOptions]:
    rig = Rig(name="hammer", model="unknown", points=(Point(id=1, x_m=0.0),), channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=1),
    ))  # fmt: skip
    files = sorted((folder / "hammer_5hits").glob("hit_*.npy"))
    return import_sources(files, rig, ImportOptions(drive_point=1)), IdentificationOptions(band_hz=(300, 5000))


def ambient(folder: Path) -> tuple[Campaign, IdentificationOptions]:
    """Cut into five records that follow each other."""
    (file,) = (folder / "uff").glob("MPSTD*.uff")
    options = ImportOptions(test="random")
    campaign = import_sources([file], draft_rig(file, options), options)
    (block,) = campaign.blocks
    n = block.n_samples // 5
    cut = tuple(replace(block, name=f"part_{k}", order=k, samples=block.samples[:, k * n : (k + 1) * n],
                        first_sample=k * n) for k in range(5))  # fmt: skip
    return replace(campaign, blocks=cut), IdentificationOptions()


def said_of(campaign: Campaign) -> str:
    """What is said before identification."""
    try:
        check_recordings(campaign)
        return " ".join(undamaged_records(campaign, campaign.blocks)[2])
    except ModallabError as error:
        return str(error)


def identified(campaign: Campaign, options: IdentificationOptions) -> Real:
    """(2, modes) frequencies and their sigmas; none where the records are rejected."""
    try:
        model = identify_chosen(campaign, options).identified[0].model
    except ModallabError:
        return np.zeros((2, 0))
    return np.array([model.frequency_hz, model.frequency_sigma_hz])


def spoil(campaign: Campaign, rng: np.random.Generator) -> tuple[Campaign, str, str, list[tuple[str, float]], int]:
    """The campaign with a fault; its kind, the channel, and each spoilt record with the time of the fault."""
    kind = KINDS[int(rng.integers(len(KINDS)))]
    row = int(rng.integers(len(campaign.rig.channels)))
    count = int(rng.choice([1, 1, 3, 5]))
    chosen = rng.choice(len(campaign.blocks), count, replace=False)
    blocks, where = list(campaign.blocks), []
    for k in map(int, chosen):
        samples = blocks[k].samples.astype(np.float64)
        first = int(rng.uniform(0.05, 0.6) * samples.shape[1])
        spoilt = kind(samples[row], first, rng)
        begin = int(np.flatnonzero(spoilt != samples[row])[0])
        samples[row] = spoilt
        blocks[k] = replace(blocks[k], samples=samples)
        where.append((blocks[k].name, begin / blocks[k].rate_hz))
    return replace(campaign, blocks=tuple(blocks)), kind.__name__, campaign.rig.channels[row].name, where, count


def names_it(said: str, channel: str, where: list[tuple[str, float]], campaign: Campaign) -> bool:
    if channel not in said:
        return False
    block = campaign.blocks[0]
    seconds = [float(v) for v in re.findall(r"from ([\d.e+-]+) s on", said)]
    seconds += [float(v) / block.rate_hz for v in re.findall(r"sample (\d+)", said)]
    length = block.n_samples / block.rate_hz
    return "dead" in said or any(abs(s - at) < NEAR * length for s in seconds for _, at in where)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--faults", type=int, default=60)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--modes", type=int, default=0)
    parser.add_argument("--csv", type=Path)
    a = parser.parse_args()
    sets = [(make.__name__, *make(a.folder)) for make in (hammer, ambient)]
    right = identified(*sets[0][1:]) if a.modes else np.zeros((2, 0))
    for name, campaign, _ in sets:
        print(name, said_of(campaign) or "sound", flush=True)
    rows = []
    for number in range(a.faults):
        rng = np.random.default_rng([a.seed, number])
        name, campaign, options = sets[int(rng.integers(2))]
        spoilt, kind, channel, where, count = spoil(campaign, rng)
        said, tried = said_of(spoilt), name == "hammer" and sum(r[8] > 0 for r in rows) < a.modes
        (found, sigma), (known, own) = (
            identified(spoilt, options) if tried else np.zeros((2, 0)),
            right[:, : 99 * tried],
        )
        near = np.abs(found[:, None] / known - 1) < SAME
        within = np.abs(found[:, None] - known) < SIGMAS * np.hypot(sigma[:, None], own)
        named = names_it(said, channel, where, campaign)
        row = (number, name, kind, channel, count, where[0][0], f"{where[0][1]:.4g}", int(named), known.size,
               int(near.any(axis=0).sum()), int((~near.any(axis=1)).sum()), int(within.any(axis=0).sum()))  # fmt: skip
        rows.append((*row, said))
        print(*row, "" if named else said[:300], flush=True)
    print("named", sum(r[7] for r in rows), "of", len(rows), "; modes kept", sum(r[9] for r in rows), "of",
          sum(r[8] for r in rows), ", within sigmas", sum(r[11] for r in rows), "; others",
          sum(r[10] for r in rows))  # fmt: skip
    if a.csv:
        with a.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([HEAD, *rows])


if __name__ == "__main__":
    main()
