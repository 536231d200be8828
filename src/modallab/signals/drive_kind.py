"""What kind of test a record is of, seen from its force: a label may be wrong, a force cannot be.

A hit is a few contacts that last for a small part of the block. A sine is explained by one tone. A chirp's frequency
moves one way all the time. What is left is random, in bursts if it stops within the block, and pseudo-random if every
block repeats the last, in its size as well.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.units import Test
from modallab.signals.signals import Signals
from modallab.signals.tone_fit import fit_frequency

CONTACT = 0.45
"""Share of the peak that a contact reaches: more than a steep filter's ringing (0.21) or noise beside weak hits."""
MOST_CONTACTS = 4
LONGEST = 0.1
"""Share of the block that the contacts of a hit last at most."""
ONE_TONE = 0.5
"""Share of the force's power that its one sine has at least."""
ONE_WAY = 0.85
"""Share of its steps in which a chirp's frequency moves the same way; where it begins again it jumps back."""
STEPS = 32
STOPPED = 0.85
"""Share of the block in which a burst acts at most."""
NOT_REPEATED = 0.02
"""Share of the force's power that the difference of one block from the next has at most where the drive is periodic:
a force that is let go by hand has the same course each time, but not the same size."""
MOST_PAIRS = 0.8
"""Share of the blocks that this holds for, against one of their neighbours."""
ONE_SIDED = 4.0
"""Times its scatter that the mean of a static force is: a burst of random drive swings to both sides."""
Look = Test | Literal["release"]
LOOKS_LIKE: dict[Look, str] = {
    "release": "the release of a static force",
    "impact": "a hit",
    "sine": "a steady sine",
    "random": "continuous random drive, or no drive",
    "burst-random": "bursts of random drive",
    "pseudo-random": "a periodic drive, the same in every block",
    "chirp": "a chirp or a swept sine",
}


_REMEDY = (
    "identify the responses alone after the release (--response-only): the release of a static load is no hit "
    "and no drive"
)


def mislabelled_records(signals: Sequence[Signals]) -> dict[str, Look]:
    """The records of which the force is not that of the test they are labelled as, and what it looks like instead.

    Records without any force are none of them.

    Args:
        signals: blocks of one test, equal in rate and length.
    """
    found: dict[str, Look] = {}
    # One shaker's records and those of several are looked at apart.
    broadband: dict[tuple[Test, int], list[Signals]] = {}
    for s in signals:
        label = s.block.test
        if not np.ptp(s.forces, axis=1).all():
            # A channel that is dead says nothing of its test: who needs the force says that there is none.
            continue
        if label not in ("impact", "sine"):
            broadband.setdefault((label, len(s.forces)), []).append(s)
        elif not (is_hit(s.force) if label == "impact" else _is_its_sine(s)):
            found[s.block.name] = _kind_of_block(s.force, s.rate_hz)
    for (label, _), of_it in broadband.items():
        seen = _kind_of_drive(label, of_it)
        # One block alone cannot show that the next is the same.
        alone = len(of_it) == 1 and {label, seen} == {"random", "pseudo-random"}
        if seen != label and not alone and not _is_periodic_sweep(label, seen, of_it):
            found |= {s.block.name: seen for s in of_it}
    return found


def check_kind(signals: Sequence[Signals]) -> tuple[list[Signals], tuple[str, ...]]:
    """The records whose force is that of their test, and a note on the others.

    Args:
        signals: blocks of one test, equal in rate and length.

    Raises:
        DataError: half of the records or more are of another kind: says of which.
    """
    wrong = mislabelled_records(signals)
    if not wrong:
        return list(signals), _sweep_note(signals)
    name, kind = next(iter(wrong.items()))
    label = next(s.block.test for s in signals if s.block.name == name)
    if 2 * len(wrong) >= len(signals):
        other = LOOKS_LIKE[kind] if kind != label else "none of these"
        raise DataError(
            f"{len(wrong)} of {len(signals)} records are labelled {label}, but their force looks like {other}",
            where=f"record {name}",
            remedy=_REMEDY
            if kind == "release"
            else f"import them as the test they are (--test {kind}), or check that the force channel is the force",
        )
    kept = [s for s in signals if s.block.name not in wrong]
    listed = ", ".join(f"{n} ({LOOKS_LIKE[k]})" for n, k in wrong.items())
    return kept, (f"Left out, because their force does not fit the label {label}: {listed}.",)


def _kind_of_drive(label: Test, signals: Sequence[Signals]) -> Look:
    """What the forces of broadband blocks look like: the label, unless one of them looks like something else."""
    for forces in zip(*(s.forces for s in signals), strict=True):
        seen = drive_kind_of(forces, signals[0].rate_hz)
        if seen != label:
            return seen
    return label


def _is_periodic_sweep(label: Test, seen: Look, signals: Sequence[Signals]) -> bool:
    """Whether a chirp is labelled as periodic, which it is if every block repeats the last; so is any multisine."""
    return (
        label == "pseudo-random"
        and seen == "chirp"
        and len(signals) > 1
        and _blocks_repeat([s.forces[0] for s in signals])
    )


def _sweep_note(signals: Sequence[Signals]) -> tuple[str, ...]:
    periodic = [s for s in signals if s.block.test == "pseudo-random"]
    if not periodic or drive_kind_of([s.forces[0] for s in periodic], periodic[0].rate_hz) == "pseudo-random":
        return ()
    return ("The force looks like a chirp that every block repeats; it is treated as a periodic drive.",)


def drive_kind_of(forces: Sequence[Real], rate_hz: float) -> Look:
    """The kind of test that forces (n,) in N of blocks of one level are of, by their majority."""
    votes: list[Look] = [_kind_of_block(force, rate_hz) for force in forces]
    most = max(votes, key=votes.count)
    repeats = most in ("random", "burst-random") and len(forces) > 1 and _blocks_repeat(forces)
    if repeats:
        return "pseudo-random"
    return most


def _kind_of_block(force: Real, rate_hz: float) -> Look:
    if _is_let_go(force):
        return "release"
    if is_hit(force):
        return "impact"
    if tone_share(force, rate_hz) > ONE_TONE:
        return "sine"
    if _moves_one_way(force):
        return "chirp"
    return "burst-random" if _active_share(force) < STOPPED else "random"


def is_hit(force: Real) -> bool:
    """Whether a force (n,) is one or a few short contacts, and nothing else of their size."""
    level = np.abs(force - np.median(force))
    loud = level > CONTACT * level.max(initial=0.0)
    contacts = int(np.count_nonzero(np.diff(loud.astype(np.int8), prepend=0) == 1))
    # Where the record begins within a contact, what it began with is not known.
    return 0 < contacts <= MOST_CONTACTS and float(loud.mean()) <= LONGEST and not loud[0]


def _is_let_go(force: Real) -> bool:
    """Whether a force (n,) is there from the start, steady, and then gone."""
    low, high = np.sort([float(np.median(force[:3])), float(np.median(force[-force.size // 4 :]))])
    acting = np.abs(force - np.median(force[-force.size // 4 :])) > (high - low) / 2
    gone = int(np.argmin(acting))
    if not acting[0] or acting[gone:].any() or gone < 3:
        return False
    held = force[:gone] - np.median(force[-force.size // 4 :])
    return abs(float(held.mean())) > ONE_SIDED * float(held.std())


def tone_share(force: Real, rate_hz: float) -> float:
    """Share of the power of a force (n,) that the one sine has that explains it best."""
    centred = force - force.mean()
    power = float(np.mean(centred**2))
    if power <= 0:
        return 0.0
    spectrum = np.abs(np.fft.rfft(centred * np.hanning(force.size)))
    strongest = max(1, int(np.argmax(spectrum))) * rate_hz / force.size
    try:
        found = fit_frequency(force[None], rate_hz, strongest)
    except DataError:
        return 0.0
    return 1 - float(found.residual_rms[0]) ** 2 / power


def _is_its_sine(signals: Signals) -> bool:
    power = float(np.var(signals.force))
    try:
        found = signals.tone
    except DataError:
        return False
    return power > 0 and 1 - float(found.residual_rms[0]) ** 2 / power > ONE_TONE


def _moves_one_way(force: Real) -> bool:
    """Whether the force's own frequency, averaged over parts of the block, keeps rising or keeps falling."""
    analytic = _analytic_signal(force - force.mean())
    turned = analytic[1:] * analytic[:-1].conj()
    parts = np.array([np.angle(part.sum()) for part in np.array_split(turned, STEPS)])
    power = np.array([np.abs(part).mean() for part in np.array_split(turned, STEPS)])
    steps = np.diff(parts[power > 0.05 * power.max(initial=0.0)])
    return steps.size >= STEPS // 4 and max(float(np.mean(steps > 0)), float(np.mean(steps < 0))) >= ONE_WAY


def _analytic_signal(values: Real) -> NDArray[np.complex128]:
    """(n,) signal without negative frequencies, of which (n,) values are the real part."""
    lines = np.fft.fft(values)
    half = values.size // 2
    # The mean, and of an even number of samples the line at half the rate, stand for themselves.
    lines[1 : (values.size + 1) // 2] *= 2
    lines[half + 1 :] = 0
    return np.fft.ifft(lines)


def _active_share(force: Real) -> float:
    """Share of the block in which there is any force to speak of."""
    power = np.array([np.mean(part**2) for part in np.array_split(force - np.median(force), STEPS)])
    return float(np.mean(power > 0.05 * np.sort(power)[-STEPS // 4 :].mean()))


def _blocks_repeat(forces: Sequence[Real]) -> bool:
    """Whether most blocks repeat the one before or the one after: several waves may follow each other."""
    centred = [f - f.mean() for f in forces]
    powers = [(float(np.sum((a - b) ** 2)), float(a @ a + b @ b) / 2) for a, b in pairwise(centred)]
    changes = [change / max(power, 1e-300) for change, power in powers]
    nearest = [min(changes[max(0, k - 1) : k + 1]) for k in range(len(forces))]
    # The first block may still be running in, and one of many may be odd.
    return float(np.quantile(nearest[len(changes) > 1 :], MOST_PAIRS)) < NOT_REPEATED
