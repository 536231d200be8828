"""Campaigns that decision pages tell of, as far as they can be made again from what is said there.

Where a page's words fit several trials of its seed, all of them are here. Not here are trials that were drawn before
trials had to matter (seeds 161803, 4711), friction and play of seed 577215, which no number on a page tells apart,
simulators with a hidden defect (`foreign.py`) and benches with few sensors (`next_run.py`).
"""

from collections.abc import Iterator

from corpus.campaigns import Entry, kind_of_truth
from modallab.blind.draw import PAIR, TrialDraw, draw_trials, pair_names
from modallab.blind.request import BlindRequest
from modallab.core.effects import catalogue, kind_of

LINEAR = tuple(name for name in catalogue() if kind_of(name).linear)
STEPPED_0228 = {424243: ("cubic_spring", "air_drag"), 535353: ("clamp_friction", "clearance", "breathing_crack")}
IN_TURN = (
    ("0226", 577215, 200, 200, (6, 18, 39, 46, 52, 54, 65)),
    ("0227", 577215, 200, 200, (115, 117, 123, 159, 322, 361)),
    ("0228", 577215, 200, 200, (160, 164, 225, 243, 278, 294, 328)),
    ("0230", 271828, 200, 200, (6, 7)),
    ("0305", 660660, 300, 300, (2, 13, 19, 22, 23, 25, 41, 44, 45, 58, 63, 70, 72, 94, 95, 99)),
    ("0313", 515152, 16, 4, (1,)),
)
"""Page, seed, numbers of trials with and without effect, and places in that order: as `in_turn.py` draws them."""
PAIRS = (
    *(("0305", 171717, k) for k in (3, 4)),
    *(("0306", 171717, k) for k in (6, 16, 17)),
    *(("0310", 414143, 3), ("0311", 373739, 17), ("0312", 515151, 6)),
    *(("0313", 515151, k) for k in (13, 16)),
    *(("0314", 616161, 9), ("0314", 717171, 13), ("0314", 818181, 8)),
)
"""Page, seed and number, as `pairs.py` draws them."""
OUTSIDE_0310 = {
    "torsion": 9340000,
    "support_resonance": 9350000,
    "axial_preload": 9360000,
    "cross_axis": 9370000,
    "preamp_lag": 9380000,
    "soft_saturation": 9390000,
    "dropouts": 9400000,
    "timing_jitter": 9410000,
    "amplifier_harmonics": 9420000,
}
"""Seeds as `unknown.py` takes them from `trials.py`."""
STRUCTURES = (
    *(("0272", "plate", "ground_spring", 51002), ("0272", "tube", "ground_spring", 51003)),
    *(("0291", "tube", "position_error", 1000 * k + 7) for k in (64, 66, 84, 85)),
)


def named() -> Iterator[Entry]:
    for page, seed, trials, none, places in IN_TURN:
        listed = draw_trials(BlindRequest(trials=trials, none=none, seed=seed, tolerances="usual", later=False))
        yield from (_own(page, seed, listed[k]) for k in places)
    for seed, effects in STEPPED_0228.items():
        yield from (_own("0228", seed, draw) for draw in _only(seed, 4 * len(effects), effects))
    yield from (_own("0297", 909090, _only(909090, 30, LINEAR)[k]) for k in (0, 1, 21))
    yield from (_own(page, seed, TrialDraw(f"p{k:03d}", PAIR, seed * 1000 + k, "usual")) for page, seed, k in PAIRS)
    yield from (_own("0310", seed, TrialDraw(name, name, seed, "usual")) for name, seed in OUTSIDE_0310.items())
    for page, bench, change, seed in STRUCTURES:
        yield Entry(f"structure_{seed}", "decisions", "structure", bench, change, str(seed), "seen", page)


def _only(seed: int, trials: int, effects: tuple[str, ...]) -> list[TrialDraw]:
    return draw_trials(BlindRequest(trials=trials, none=0, seed=seed, effects=effects, tolerances="usual", later=False))


def _own(page: str, seed: int, draw: TrialDraw) -> Entry:
    names = pair_names(draw.seed) if draw.effect == PAIR else [draw.effect]
    name = f"seed_{seed}_{draw.name}"
    return Entry(name, "decisions", kind_of_truth(names), "usual", draw.effect, str(draw.seed), "seen", page)
