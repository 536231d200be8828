"""The response to hits that no fit has seen, predicted from the model of the others.

    python benchmarks/held_out_hits.py demo held-out-hits.csv

The last hit at each point is held out. A row is an output of a held-out hit, with its error from 3 to 650 Hz as a share
of the record.
"""

import csv
import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

import modallab as ml
from modallab.core.block import Block
from modallab.notebook.recording import Recording
from modallab.signals.signals import to_signals_of

BAND_HZ = (3.0, 650.0)


def main() -> None:
    campaign, out = ml.load(sys.argv[1]).campaign, Path(sys.argv[2])
    by_point: dict[int, list[Block]] = defaultdict(list)
    for block in campaign.of("impact"):
        assert block.drive_point is not None
        by_point[block.drive_point].append(block)
    seen = tuple(b for blocks in by_point.values() for b in blocks[:-1])
    model = ml.identify(Recording(replace(campaign, blocks=seen)), "impact", progress=False)
    rows = [row for point, blocks in by_point.items() for row in errors_of(model, point, blocks[-1])]
    with out.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("point", "output", "error"), *rows])
    errors = 100 * np.array([float(row[2]) for row in rows])
    print(f"{len(rows)} records held out: error {np.median(errors):.2g} % (median), {errors.max():.2g} % at most")


def errors_of(model: ml.Model, point: int, block: Block) -> list[tuple[int, int, str]]:
    """Point, output and error of each record of a hit."""
    (held,) = to_signals_of([block], model.campaign.rig)
    outputs = [p for p in model.modal.output_points if p is not None]
    errors = model.response(held.force, 1 / held.rate_hz, at=point, of=outputs).error(held.responses, BAND_HZ)
    return [(point, p, f"{e:.4g}") for p, e in zip(outputs, errors, strict=True)]


if __name__ == "__main__":
    main()
