"""Trials whose campaign shows an effect and does not distinguish it from another: what `next_run.py` begins with."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from modallab.blind.draw import draw_rig, with_changed_mounting
from modallab.core.effects import Effect, kind_of
from modallab.core.plan import HitAcceptance, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig, Tolerance
from modallab.gap.design.distinguishability import distinguishability_of_data
from modallab.gap.design.planned import HIT_N, records_of_plans
from modallab.gap.model.candidates import beam_candidates, channel_candidates, has_needed_tests
from modallab.gap.model.fit import Problem
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.nuisances import nuisances
from modallab.twin.candidate import CandidateEffect, FreeNumber
from modallab.twin.effects import apply_effect

EFFECTS = (
    *("clamp_rotation", "clamp_translation", "added_mass", "sensor_mass", "stiffness_loss", "ground_spring"),
    *("gain_error", "position_error", "hit_position", "force_gain", "channel_skew", "trigger_delay"),
    *("stinger_moment", "shaker_mass", "local_damper", "ac_coupling", "loose_mount"),
)
SEEN, APART, SAME = 20.0, 3.0, 0.1
"""Noise units over all records, beyond tolerances: what an effect leaves at least, by how much it differs at most from
the one that is most like it, and by which share of itself if it is the same."""
KEPT = 1 / 10
"""Share of benches on which an effect may be the same as another to every test of the rig."""
TRIES = 15
"""Effects that are drawn for a bench at most."""
MOST = 1000.0
"""What it leaves at most."""
HALVED = 12
"""Halvings of the range in which its size is looked for."""
MOVES = 0.04
"""Share of the response that an effect on a bench as built moves at least: less is no gap there."""
BUILT = 1 / 3
"""Share of benches as built: their diagnoses take longer."""
PLACES = tuple(np.linspace(0.1, 0.98, 12).tolist())
"""Places over L at which others are tried."""
SENSORS = {"tip": (10,), "middle": (6,), "low": (3,), "close": (6, 7), "two": (5, 10), "three": (3, 7, 10)}
BENCH = "sim://cantilever?k_root=inf&bad_hits=0&n_per_v=2&peak_n=10,35"
"""Struck as softly as the tip in blind trials."""
SOFTER = 22.0 / HIT_N
"""Their force over that of the hits that are planned with."""
STILL = HitAcceptance(max_residual_ratio=3e-4, check_point=False)
"""As for the experiments that follow: with few sensors nobody sees where a hit landed."""
PLANS: dict[str, ImpactPlan] = {
    "hits at 3": ImpactPlan(points=(3,), hits=2, acceptance=STILL),
    "hits at 6": ImpactPlan(points=(6,), hits=2, acceptance=STILL),
    "hits at 10": ImpactPlan(points=(10,), hits=2, acceptance=STILL),
}


def with_sensors(rig: Rig, points: tuple[int, ...]) -> Rig:
    """The rig with the force and the accelerometers at these points only."""
    kept = [c for c in rig.channels if c.point is None or c.point in points]
    return rig.model_copy(update={"channels": tuple(c.model_copy(update={"index": k}) for k, c in enumerate(kept))})


def _small(slot: FreeNumber) -> float:
    if slot.power < 0:
        return 10 * max(slot.starts)
    return slot.none * 1.003 if slot.none else min(v for v in slot.starts if v > 0) / 30


def _large(slot: FreeNumber) -> float:
    return min(slot.starts) / 30 if slot.power < 0 else max(slot.starts)


class Sight:
    """What a campaign of a plan sees: signatures in noise units, beyond what tolerances may do (as "
    "`distinguishability_of_data`)."""

    def __init__(self, rig: Rig, plans: Sequence[Plan]) -> None:
        points = [(rig.x_of(p), plan.hits) for plan in plans if isinstance(plan, ImpactPlan) for p in plan.points]
        self.rig, self.data = rig, records_of_plans(rig, plans)
        self.base = Problem(self.data, nuisances(rig, 450.0, points))
        zero = np.zeros(self.base.size)
        self.nothing = self.base.residual(zero)
        slopes = jacobian(self.base, zero, self.nothing)
        self.free, _ = np.linalg.qr(np.vstack([slopes, np.eye(self.base.size)]))
        self.alike = {
            name
            for pair in distinguishability_of_data(self.data, points, EFFECTS).indistinguishable_pairs()
            for name in pair[:2]
        }

    def of(self, effect: Effect) -> np.ndarray:
        """What an effect leaves."""
        twin = apply_effect(self.base.twin(np.zeros(self.base.size)), effect, self.rig)
        moved = self.base.residual_of(twin, forward(twin, self.data)) - self.nothing
        padded = np.concatenate([moved, np.zeros(self.base.size)])
        return SOFTER * (padded - self.free @ (self.free.T @ padded))

    @property
    def candidates(self) -> list[CandidateEffect]:
        """Effects of every kind, at every sensor."""
        channels = [channel_candidates(self.rig, c) for c in self.data.channels]
        found = [c for listed in (beam_candidates(self.rig), *channels) for c in listed]
        return [c for c in found if c.effect in EFFECTS and has_needed_tests(c, self.data)]

    @cached_property
    def others(self) -> list[tuple[str, np.ndarray]]:
        """The same in a small size, at many places, as unit vectors."""
        found: list[tuple[str, np.ndarray]] = []
        for c in self.candidates:
            for x in PLACES if any(s.name == "x" for s in c.slots) else (1.0,):
                left = self.of(
                    c.effect_at(np.array([s.coordinate(x if s.name == "x" else _small(s)) for s in c.slots]))
                )
                found.append((c.effect, left / max(float(np.linalg.norm(left)), 1e-12)))
        return found

    def apart(self, effect: Effect) -> tuple[float, float, str]:
        """Noise units that an effect leaves, those by which it differs from the one most like it, and that one."""
        left = self.of(effect)
        size = float(np.linalg.norm(left))
        like, other = max((abs(float(left @ v)) / max(size, 1e-12), n) for n, v in self.others if n != effect.effect)
        return size, size * float(np.sqrt(max(1 - like**2, 0.0))), other

    def sized(self, c: CandidateEffect, x: float, size: float) -> Effect:
        """An effect at a place that leaves so much, or as much as it can."""
        (slot,) = (s for s in c.slots if s.name != "x")
        small, large = _small(slot), _large(slot)

        def at(share: float) -> Effect:
            value = float(np.sign(large) * np.exp((1 - share) * np.log(abs(small)) + share * np.log(abs(large))))
            return c.effect_at(np.array([s.coordinate(x if s.name == "x" else value) for s in c.slots]))

        low, high = 0.0, 1.0
        for _ in range(HALVED):
            middle = (low + high) / 2
            low, high = (middle, high) if np.linalg.norm(self.of(at(middle))) < size else (low, middle)
        return at(low)

    def same(self, effect: Effect) -> bool:
        """Whether another effect is the same on all that the rig can do."""
        seen, apart, _ = self.whole.apart(effect)
        return apart < SAME * seen

    @cached_property
    def whole(self) -> "Sight":
        """What all that the rig can do sees."""
        return Sight(self.rig, [ImpactPlan(points=tuple(p.id for p in self.rig.points), hits=5), SinePlan()])

    def moves(self, effect: Effect) -> float:
        """Share of the response that an effect moves, on the channel where it is most."""
        zero = np.zeros(self.base.size)
        there, here = (
            forward(t, self.data) for t in (apply_effect(self.base.twin(zero), effect, self.rig), self.base.twin(zero))
        )
        return max(
            float(np.max(np.linalg.norm(a - b, axis=1) / np.linalg.norm(b, axis=1)))
            for a, b in zip(there, here, strict=True)
        )


def drawn(seed: int, names: Sequence[str] = EFFECTS) -> dict[str, Any] | None:
    """A trial of one of these effects: rig, plan, effect and the bench's address; None where all are distinguished."""
    rng = np.random.default_rng([seed, 16])
    rough = bool(rng.random() < BUILT)
    sensors, plan = str(rng.choice(list(SENSORS))), str(rng.choice(list(PLANS)))
    rig = with_sensors(draw_rig(seed), SENSORS[sensors])
    if rough:
        rig = with_changed_mounting(rig.model_copy(update={"tolerance": Tolerance.usual()}), seed)
    sight = Sight(rig, [PLANS[plan]])
    listed = [
        c
        for c in sight.candidates
        if c.effect in sight.alike and c.effect in names and sum(s.name != "x" for s in c.slots) == 1
    ]
    if not listed:
        return None
    keeps = rng.random() < KEPT
    for _ in range(TRIES):
        effect, seen, apart, other = attempt(sight, listed[int(rng.integers(len(listed)))], rng)
        if not (seen >= SEEN and apart <= APART and (not rough or sight.moves(effect) >= MOVES)):
            continue
        if apart < SAME * seen and not keeps and sight.same(effect):
            continue
        words = [f"{k}={v!r}" for k, v in effect.parameters.items()]
        words += [f"{k}={v}" for k, v in effect.place.model_dump().items() if kind_of(effect.effect).place == k]
        own = f"effect={','.join([effect.effect, *words])}" + ("&tolerances=usual" if rough else "")
        return {"rig": rig, "plan": plan, "sensors": sensors, "effect": effect, "other": other, "rough": rough,
                "seen": seen, "apart": apart, "url": f"{BENCH}&seed={seed}&{own}"}  # fmt: skip
    return None


def attempt(sight: Sight, candidate: CandidateEffect, rng: np.random.Generator) -> tuple[Effect, float, float, str]:
    """An effect somewhere, made smaller, if need be, until it is like another, and what `apart` says of it."""
    x = round(float(rng.uniform(0.15, 0.98)), 3)
    size = float(np.exp(rng.uniform(*np.log((SEEN, MOST)))))
    effect = sight.sized(candidate, x, size)
    apart = sight.apart(effect)[1]
    effect = sight.sized(candidate, x, size * min(1.0, APART * float(rng.uniform(0.3, 1.0)) / max(apart, 1e-9)))
    return effect, *sight.apart(effect)
