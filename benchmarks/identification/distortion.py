"""The distortion level of the simulated bench's cubic spring, from a shaker test that leaves lines out.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/distortion.py --seeds 1 2 3 --out FOLDER

A cubic spring stands at 0.8 L. Multisines of odd lines, of which each wave leaves out another fourth, are planned and
driven as by a user, the records identified, and the levels of odd and even distortions read. The truth is the periodic
motion under the force that was played, by harmonic balance, at the same lines (distortion_truth.py). Campaigns are kept
in the folder and not recorded again. Sensors where noise hides the truth
or it is below FLOOR are not counted.
"""

import argparse
from pathlib import Path

import numpy as np
from distortion_truth import Balance
from numpy.typing import NDArray

import modallab as ml
from modallab.core.block import Campaign
from modallab.core.plan import BroadbandPlan
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.frf.distortions import group_blocks_by_wave
from modallab.frf.undriven_lines import UndrivenDistortions
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.averaged_frfs import distortions_of
from modallab.pipelines.identify import identify_campaign, usable_blocks
from modallab.signals.signals import Signals

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

PLACE = 0.8
BAND_HZ = (2.0, 40.0)
BLOCK_S = 4.096
HARMONICS = 3
FLOOR = 1e-3
"""What the bench without a spring is read as having is below this."""
HIDDEN = 3.0
"""Times the noise of the averaged periods, both over the response, that a distortion must be to be counted."""
GOAL = 20.0
HEAD = "seed drive V  sensors  odd % at the worst: read, true   off %: median, worst   even % there: read, true"


def recorded(folder: Path, seed: int, k3: float, volts: float, waves: int, settle_s: float) -> Campaign:
    path = folder / f"cubic_{seed}_{k3:g}_{volts:g}_{waves}_{settle_s:g}.h5"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        plan = BroadbandPlan(
            signal="pseudo-random", band_hz=BAND_HZ, block_s=BLOCK_S, levels_v={"one": volts}, seed=seed,
            detection_lines=True, blocks_per_wave=3, blocks=3 * waves, settle_s=settle_s,
        )  # fmt: skip
        effect = f"cubic_spring,k3={k3:g},x={PLACE:g}" if k3 else ()
        ml.simulate(effect=effect, seed=seed, plan=plan, progress=False).save(path)
    return read_campaign(path)


def truth(campaign: Campaign, signals: list[Signals], seed: int, k3: float) -> tuple[Real, Real]:
    """(outputs,) odd and even levels of the periodic motion under the forces that were played."""
    first, rig = signals[0], campaign.rig
    line_hz, last = first.rate_hz / first.force.size, int(BAND_HZ[1] * BLOCK_S + 1e-9)
    force = np.stack([np.fft.rfft(s.force) for s in signals])
    count = HARMONICS * last + 1
    # Of a period in as many samples as the balance has.
    scale = 2 * (count - 1) / first.force.size
    assert rig.beam is not None
    at_m = PLACE * rig.beam.length_m
    balance = Balance.beam_candidates(f"sim://cantilever?seed={seed}", rig, line_hz, count, at_m, k3)
    nearest = int(np.argmin([abs(rig.x_of(c.point or 0) - at_m) for c in rig.responses]))
    omega2 = (2 * np.pi * line_hz * np.maximum(np.arange(count), 1)) ** 2
    driven, power = [], []
    for wave in group_blocks_by_wave(force[:, : last + 1]):
        played = force[wave].mean(axis=0)[:count] * scale
        holds = np.abs(played) > 0.1 * np.abs(played).max()
        moved = -np.mean([np.fft.rfft(signals[b].responses[nearest])[:count] for b in wave], axis=0) * scale / omega2
        answer = balance.accelerations(np.where(holds, played, 0), moved)
        driven.append(holds[: last + 1])
        power.append(np.abs(answer[:, : last + 1]) ** 2)
    return levels(np.stack(power), np.stack(driven))


def levels(power: Real, driven: NDArray[np.bool_]) -> tuple[Real, Real]:
    """(outputs,) rms at odd lines while left out, and at even lines, over that of what is driven.

    Args:
        power: (waves, outputs, lines) from 0.
        driven: (waves, lines).
    """
    times, waves = driven.sum(axis=0), len(driven)
    both = (times > 0) & (times < waves)
    answer = np.einsum("wol,wl->ol", power, driven) / waves
    undriven = np.einsum("wol,wl->ol", power, ~driven) * times / np.maximum(waves - times, 1) / waves
    low, high = np.flatnonzero(times)[[0, -1]]
    even = power[:, :, low + 1 : high : 2].mean(axis=0).sum(axis=1)
    odd = undriven[:, both].sum(axis=1) / answer[:, both].sum(axis=1)
    return np.sqrt(odd), np.sqrt(even / answer.sum(axis=1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--k3", type=float, default=1e8)
    parser.add_argument("--volts", type=float, nargs="+", default=[0.1, 0.2, 0.4])
    parser.add_argument("--waves", type=int, default=12)
    parser.add_argument("--settle-s", type=float, default=8.0)
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args()
    off: list[float] = []
    print(HEAD)
    for seed in a.seeds:
        for volts in a.volts:
            campaign = recorded(a.out, seed, a.k3, volts, a.waves, a.settle_s)
            signals, _, _ = usable_blocks(campaign, campaign.of("pseudo-random"))
            found = distortions_of(signals, identify_campaign(campaign, IdentificationOptions()).identified[0].model)
            assert isinstance(found, UndrivenDistortions)
            try:
                odd, even = truth(campaign, signals, seed, a.k3)
            except ArithmeticError as error:
                print(f"{seed:4d} {volts:7g}   no truth: {error}", flush=True)
                continue
            seen = odd > np.maximum(FLOOR, HIDDEN * found.noise_level / np.sqrt(found.waves * found.periods))
            each = 100 * np.abs(found.odd[seen] / odd[seen] - 1)
            off += each.tolist()
            most = int(np.argmax(odd))
            both = f"{100 * found.odd[most]:14.4f} ± {100 * found.odd_sigma[most]:.4f} {100 * odd[most]:10.4f}"
            worst = f"{np.median(each):14.1f} {each.max():8.1f}" if each.size else f"{'':23s}"
            evens = f"{100 * found.even[most]:16.4f} {100 * even[most]:10.4f}"
            print(f"{seed:4d} {volts:7g} {seen.sum():6d}   {both} {worst} {evens}", flush=True)
    if off:
        within = sum(one <= GOAL for one in off)
        print(f"{within} of {len(off)} levels within {GOAL:g} %; median {np.median(off):.1f} %, worst {max(off):.1f} %")


if __name__ == "__main__":
    main()
