"""A random test with noise on the force: how many 95 % intervals hold the truth, and how well the bias is stated.

    python benchmarks/identification/force_noise.py --seeds 200 [--first 0] --out FILE.csv

Modes at 60 Hz, 1 % and 140 Hz, 0.8 %, three points, driven at the first. A seed draws the noise, 0 to 20 % of the
force, 1 to 20 blocks of 1.024 s, whether they follow each other without a gap, and what the noise is: of the force
channel, or a force that was not measured. Records are cut out of a longer one, so that they begin and end while the
structure rings. All FRFs are of the local polynomial method, taken as H1, H2 and Hv. A row of FILE has the draw, the
errors in sigmas of frequencies, damping ratios and modal constants, the constants' mean error, and the bias that the
note states for it.
"""

import argparse
import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.core.units import FRF_ESTIMATORS, FrfEstimator
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign

RATE_HZ, SAMPLES, HZ, ZETA = 1000.0, 1024, np.array([60.0, 140.0]), np.array([0.01, 0.008])
PHI = np.array([[1.0, 0.8], [0.6, -0.9], [-0.5, 0.4]])
NAMES = ("force", "a1", "a2", "a3")
ERRORS = tuple(f"{name}{mode}" for name in ("f", "zeta", "A") for mode in (1, 2))
COLUMNS = ("seed", "noise", "blocks", "gaps", "source", "estimator", "modes", *ERRORS, "off", "stated")
RIG = Rig(
    name="three points",
    model="unknown",
    points=tuple(Point(id=k, x_m=0.1 * k) for k in (1, 2, 3)),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        *(Channel(index=k, name=f"a{k}", quantity="acceleration", unit="m/s^2", point=k) for k in (1, 2, 3)),
    ),
)


@dataclass(frozen=True)
class Drawn:
    """Of a seed: noise as a share of the force, count of blocks, whether there are gaps, and which force is noisy."""

    noise: float
    blocks: int
    gaps: bool
    source: str


def drawn(rng: np.random.Generator) -> Drawn:
    """What a seed decides."""
    noise, blocks = float(rng.uniform(0, 0.2)), int(rng.integers(1, 21))
    return Drawn(noise, blocks, bool(rng.integers(2)), str(rng.choice(["channel", "unmeasured"])))


def campaign(one: Drawn, rng: np.random.Generator) -> Campaign:
    """Blocks out of one long periodic record; responses are exact but for noise of 0.1 %."""
    n = (2 * one.blocks + 2) * SAMPLES
    force, noise = rng.normal(size=n), one.noise * rng.normal(size=n)
    omega, w = 2 * np.pi * np.fft.rfftfreq(n, 1 / RATE_HZ), 2 * np.pi * HZ[:, None]
    modes = -(omega**2) / (w**2 - omega**2 + 2j * ZETA[:, None] * w * omega)
    acting = force + noise if one.source == "unmeasured" else force
    responses = np.fft.irfft((PHI * PHI[0]) @ modes * np.fft.rfft(acting), n)
    responses += 1e-3 * responses.std() * rng.normal(size=responses.shape)
    samples = np.vstack([force + noise if one.source == "channel" else force, responses])
    starts = [k * SAMPLES * (2 if one.gaps else 1) for k in range(one.blocks)]
    return Campaign(RIG, tuple(block(samples[:, at : at + SAMPLES], k, at) for k, at in enumerate(starts)))


def block(samples: NDArray[np.float64], order: int, at: int) -> Block:
    """One of them."""
    units = ("N", *["m/s^2"] * 3)
    return Block(
        f"run{order}", "random", order, RATE_HZ, samples, np.ones(4), units, NAMES, drive_point=1, first_sample=at
    )


def errors(model: ModalModel) -> dict[str, float]:
    """Of frequencies, damping ratios and constants in sigmas, and the constants' mean error."""
    constants, true = model.modal_constants[:, 0, 0].real, PHI[0] ** 2
    sigma = model.modal_constant_sigma[:, 0, 0]
    if model.modal_constant_part_sigma is not None:
        sigma = model.modal_constant_part_sigma[:, 0, 0].real
    rows = (
        (model.frequency_hz - HZ) / model.frequency_sigma_hz,
        (model.damping_ratio - ZETA) / model.damping_sigma,
        (constants - true) / sigma,
    )
    return dict(zip(ERRORS, np.ravel(rows).tolist(), strict=True)) | {"off": float(np.mean(constants / true - 1))}


def stated(model: ModalModel, source: str) -> float:
    """Bias of the constants that the note gives for this source; 0 where it says nothing."""
    said = " ".join(model.notes)
    found = re.search(r"constants are ([\d.e-]+) % low" if source == "channel" else r"they are ([\d.e-]+) % high", said)
    return (-0.01 if source == "channel" else 0.01) * float(found[1]) if found else 0.0


def row(one: Drawn, measured: Campaign, how: FrfEstimator) -> dict[str, object]:
    """Of the table; a model with other than two modes has no errors."""
    try:
        (found,) = identify_campaign(measured, IdentificationOptions(frf=how)).identified
    except ModallabError:
        return {"estimator": how, "modes": 0}
    facts: dict[str, object] = {"estimator": how, "modes": found.model.n_modes}
    if found.model.n_modes != HZ.size:
        return facts
    return facts | errors(found.model) | {"stated": stated(found.model, one.source)}


def main() -> None:
    """Write a row for each seed and estimator."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    with asked.out.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for seed in range(asked.first, asked.first + asked.seeds):
            rng = np.random.default_rng(seed)
            one = drawn(rng)
            measured, facts = campaign(one, rng), {"seed": seed} | vars(one)
            for how in FRF_ESTIMATORS:
                writer.writerow(facts | row(one, measured, how))
            file.flush()
    summarised(asked.out)


def summarised(path: Path) -> None:
    """Print what the table shows, by estimator and source."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    for how in FRF_ESTIMATORS:
        for source in ("channel", "unmeasured", ""):
            some = [r for r in rows if r["estimator"] == how and r["source"].endswith(source)]
            good = [r for r in some if r["off"]]
            held = [np.mean([abs(float(r[n + m])) < 1.96 for r in good for m in "12"]) for n in ("f", "zeta", "A")]
            off, said = (sum(float(r[name]) for r in good) for name in ("off", "stated"))
            print(
                f"{how}, {source or 'both'}: {len(good)} of {len(some)} with both modes; held f {held[0]:.3f}, "
                f"zeta {held[1]:.3f}, A {held[2]:.3f}; mean A off {100 * off / len(good):+.3f} %, "
                f"stated {100 * said / len(good):+.3f} %"
            )


if __name__ == "__main__":
    main()
