"""Effects that no catalogue names, put into measured FRFs of any structure: none may get a name above 0.9.

    python benchmarks/gap/measured_outside.py CAMPAIGN.h5 --seed 11 --each 2 --out rows.csv
    python benchmarks/gap/measured_outside.py CAMPAIGN.h5 --seed 11 --each 2 --out rows.csv --band 40 800

Each trial is the measured structure with one such effect of a drawn size and with noise drawn anew. It is held against
the model of the FRFs as they were measured. "nothing" is nothing but noise.
"""

import argparse
import csv
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.blind.measured.draw import driving_points
from modallab.blind.measured.run import with_noise
from modallab.core.errors import IdentificationError
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.frf.estimate import variance_of
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.identification.frf_model import frf_in_band, identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.freedoms import with_points
from modallab.modification.frfs import receptances_of_model
from modallab.pipelines.structure_trials import measured_frf

Complex = NDArray[np.complex128]
SURE = 0.9
COLUMNS = (
    "campaign", "kind", "trial", "said", "probability", "nothing", "unknown", "before", "numbers", "seconds", "wrong",
)  # fmt: skip


@dataclass(frozen=True)
class Bench:
    """What was measured, what was identified from it, and the trial's random numbers."""

    frf: Frf
    model: ModalModel
    rig: Rig
    rng: np.random.Generator

    @property
    def s(self) -> Complex:
        return np.asarray(2j * np.pi * self.frf.frequency_hz)

    @property
    def top(self) -> float:
        return float(self.model.frequency_hz.max())

    def within(self, low: float, high: float) -> float:
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def modelled(self, model: ModalModel, by: float = 1.0) -> Complex:
        """(outputs, inputs, lines) what is measured of a model, in the quantity of the FRFs; by times as fast."""
        s = self.s / by
        return np.asarray(np.moveaxis(receptances_of_model(model, s), 0, -1) * s ** DERIVATIVES[self.frf.quantity])

    def of_model(self, changed: ModalModel) -> Complex:
        """What was measured with the model's modes as they were changed."""
        return np.asarray(self.frf.values + self.modelled(changed) - self.modelled(self.model))

    def hung(self, z: Complex) -> Complex:
        """With dynamic stiffness z at a driven point where a sensor stands."""
        o, i = driving_points(self.model, self.rig)[0]
        rate = self.s ** DERIVATIVES[self.frf.quantity]
        h = self.frf.values / rate
        sense = -1.0 if np.sum(self.model.modal_constants[:, o, i].real) < 0 else 1.0
        through = sense * z / (1 + sense * z * h[o, i])
        return np.asarray((h - h[:, i, None] * through * h[None, o]) * rate)

    def modal_mass(self, mode: int) -> float:
        o, i = driving_points(self.model, self.rig)[0]
        return float(1 / np.abs(self.model.modal_constants[mode, o, i]))

    def stretched(self, columns: slice | int, by: float) -> Complex:
        """Some inputs' FRFs as if every frequency were `by` times higher."""
        f, values = self.frf.frequency_hz, self.frf.values.copy()
        # Straight from line to line a resonance would be damped more: the model tells it, and the rest is even.
        left = (values - self.modelled(self.model))[:, columns]
        flat = left.reshape(-1, f.size)
        there = [np.interp(f / by, f, row.real) + 1j * np.interp(f / by, f, row.imag) for row in flat]
        values[:, columns] = np.reshape(there, left.shape) + self.modelled(self.model, by)[:, columns]
        return values


def absorber(b: Bench) -> Complex:
    """A small mass on a spring, tuned near a mode."""
    mode = int(b.rng.integers(b.model.n_modes))
    w, m = 2 * np.pi * float(b.model.frequency_hz[mode]) * b.rng.uniform(0.95, 1.05), b.modal_mass(mode)
    m *= b.within(0.01, 0.05)
    own = m * w**2 * (1 + 0.02j * b.s.imag / w)
    return b.hung(m * b.s**2 * own / (m * b.s**2 + own))


def lossy_spring(b: Bench) -> Complex:
    """A spring to ground of rubber: half of its stiffness is loss."""
    k = b.within(0.02, 0.2) * min(b.modal_mass(n) * (2 * np.pi * f) ** 2 for n, f in enumerate(b.model.frequency_hz))
    return b.hung(np.full(b.s.size, k * (1 + 0.5j)))


def cable_crosstalk(b: Bench) -> Complex:
    """One channel reads a share of the force's cable as well."""
    values, o = b.frf.values.copy(), int(b.rng.integers(len(b.frf.values)))
    values[o] += b.rng.choice([-1, 1]) * b.within(0.1, 0.5) * np.median(np.abs(values[o]))
    return values


def channel_crosstalk(b: Bench) -> Complex:
    """One channel reads a share of another one as well."""
    values, n = b.frf.values.copy(), len(b.frf.values)
    o, p = b.rng.choice(n, 2, replace=False)
    share = np.linalg.norm(values[o]) / np.linalg.norm(values[p])
    values[o] += b.rng.choice([-1, 1]) * b.within(0.1, 0.5) * share * b.frf.values[p]
    return values


def low_pass(b: Bench) -> Complex:
    """One channel behind a filter of the second order, whose corner is near the band's end."""
    values, o = b.frf.values.copy(), int(b.rng.integers(len(b.frf.values)))
    ratio = b.s / (2 * np.pi * b.top * b.within(0.7, 1.5))
    values[o] /= ratio**2 + np.sqrt(2) * ratio + 1
    return values


def loose_mount(b: Bench) -> Complex:
    """One sensor on a soft mount, which resonates in or above the band."""
    values, o = b.frf.values.copy(), int(b.rng.integers(len(b.frf.values)))
    ratio = b.s / (2 * np.pi * b.top * b.within(0.8, 1.6))
    values[o] *= (1 + 0.06 * ratio) / (ratio**2 + 0.06 * ratio + 1)
    return values


def clock(b: Bench) -> Complex:
    """The frequency axis is off by 1 to 5 %: a clock, or a structure that is stiffer everywhere."""
    return b.stretched(slice(None), 1 + b.rng.choice([-1, 1]) * b.within(0.01, 0.05))


def warm_set_up(b: Bench) -> Complex:
    """One of several hit points was measured when the structure was warm: E was 3 % less."""
    return b.stretched(int(b.rng.integers(b.frf.values.shape[1])), 1 - b.within(0.01, 0.02))


def softening(b: Bench) -> Complex:
    """At a higher level joints slip: some modes are lower by up to 2 %, and damped up to three times more."""
    slips = b.rng.random(b.model.n_modes)
    lower, damped = 1 - 0.02 * slips, 1 + 2 * slips
    changed = {"frequency_hz": b.model.frequency_hz * lower, "damping_ratio": b.model.damping_ratio * damped}
    return b.of_model(b.model.model_copy(update=changed))


def hardening(b: Bench) -> Complex:
    """At a higher level one mode is higher by 1 to 5 %, and the others are as they were."""
    hz = b.model.frequency_hz.copy()
    hz[int(b.rng.integers(hz.size))] *= 1 + b.within(0.01, 0.05)
    return b.of_model(b.model.model_copy(update={"frequency_hz": hz}))


def window(b: Bench) -> Complex:
    """An exponential window on the responses alone, which nobody corrected."""
    more = b.within(0.5, 3.0) * float(np.median(b.model.damping_ratio * b.model.frequency_hz))
    changed = {"damping_ratio": b.model.damping_ratio + more / b.model.frequency_hz}
    return b.of_model(b.model.model_copy(update=changed))


def hum(b: Bench) -> Complex:
    """A cable's hum and its harmonics in one channel."""
    values, f = b.frf.values.copy(), b.frf.frequency_hz
    o, size = int(b.rng.integers(len(values))), b.within(0.2, 2.0)
    for k in range(1, int(f[-1] // 50) + 1):
        at = int(np.argmin(np.abs(f - 50 * k)))
        turn = np.exp(2j * np.pi * b.rng.random(values.shape[1]))
        values[o, :, at] += size * np.sqrt(np.mean(np.abs(values[o]) ** 2, axis=-1)) / k * turn
    return values


def shapes_changed(b: Bench) -> Complex:
    """Every modal constant is off by itself by 10 to 30 %: another specimen of the structure."""
    off = b.rng.standard_normal(b.model.modal_constants.shape) * b.within(0.1, 0.3)
    hz = b.model.frequency_hz * (1 + 0.02 * b.rng.standard_normal(b.model.n_modes))
    changed = {"modal_constants": b.model.modal_constants * (1 + off), "frequency_hz": hz}
    return b.of_model(b.model.model_copy(update=changed))


def swapped(b: Bench) -> Complex:
    """Two hit points were exchanged."""
    values, (i, j) = b.frf.values.copy(), b.rng.choice(b.frf.values.shape[1], 2, replace=False)
    values[:, [i, j]] = values[:, [j, i]]
    return values


def one_hit_weak(b: Bench) -> Complex:
    """The hammer was turned at one of several points: half of its force went along, all of it was read."""
    values, i = b.frf.values.copy(), int(b.rng.integers(b.frf.values.shape[1]))
    values[:, i] *= b.rng.uniform(0.4, 0.7)
    return values


def nothing(b: Bench) -> Complex:
    return b.frf.values


KINDS: tuple[Callable[[Bench], Complex], ...] = (
    nothing, absorber, lossy_spring, cable_crosstalk, channel_crosstalk, low_pass, loose_mount, clock, warm_set_up,
    softening, hardening, window, hum, shapes_changed, swapped, one_hit_weak,
)  # fmt: skip
NEEDS = {"channel_crosstalk": 0, "warm_set_up": 1, "swapped": 1, "one_hit_weak": 1}
"""Of FRFs (outputs, inputs, lines) the axis that has to be longer than 1."""
TRUE = {"lossy_spring": "ground_spring"}
"""What of these a name of the catalogue says truly."""
AT_A_POINT = ("absorber", "lossy_spring")


def possible(name: str, b: Bench) -> bool:
    if name in AT_A_POINT:
        return bool(driving_points(b.model, b.rig))
    return name not in NEEDS or b.frf.values.shape[NEEDS[name]] > 1


def said(b: Bench, values: Complex, number: tuple[int, int]) -> dict[str, object]:
    there = with_noise(replace(b.frf, values=values), variance_of(b.frf), np.random.default_rng(number))
    begun = time.process_time()
    try:
        bench = with_points(identify_frf(there, b.rig, IdentificationOptions())[0], b.rig)
        found = diagnose_by_model(b.model, bench, b.rig, frfs=(b.frf, there))
    except IdentificationError:
        return {"said": "not_identified", "probability": 0.0}
    named = found.effects[0] if found.effects else None
    return {
        "said": named.effect if named else found.verdict,
        "probability": round(named.probability, 4) if named else 0.0,
        "nothing": round(found.nothing, 4),
        "unknown": round(found.unknown, 4),
        "before": round(found.before, 4),
        "numbers": dict(named.parameters) if named else "",
        "seconds": round(time.process_time() - begun, 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--each", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", default=[kind.__name__ for kind in KINDS])
    parser.add_argument("--band", type=float, nargs=2)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    campaign = read_campaign(arguments.campaign)
    frf = frf_in_band(measured_frf(campaign), arguments.band)
    model = with_points(identify_frf(frf, campaign.rig, IdentificationOptions())[0], campaign.rig)
    new = not arguments.out.exists()
    for name in arguments.kinds:
        kind = next(k for k in KINDS if k.__name__ == name)
        for n in range(arguments.each):
            number = (arguments.seed, [k.__name__ for k in KINDS].index(name) * 1000 + n)
            b = Bench(frf, model, campaign.rig, np.random.default_rng(number))
            if not possible(name, b):
                continue
            row = {"campaign": arguments.campaign.stem, "kind": name, "trial": n, **said(b, kind(b), number)}
            row["wrong"] = float(str(row["probability"])) > SURE and row["said"] != TRUE.get(name)
            with arguments.out.open("a", newline="") as file:
                rows = csv.DictWriter(file, COLUMNS)
                if new:
                    rows.writeheader()
                rows.writerow(row)
            new = False
            print(row, flush=True)


if __name__ == "__main__":
    main()
