"""The experiment that would distinguish what this campaign cannot."""

from modallab.core.block import Campaign
from modallab.core.diagnosis import Verdict
from modallab.gap.model.fit import Fit

SEPARATES: dict[frozenset[str], str] = {
    frozenset({"added_mass", "sensor_mass"}): "Take all accelerometers but one off and repeat the hits: if the "
    "frequencies rise alike, it is the sensors.",
    frozenset({"added_mass", "clamp_rotation"}): "Screw a known mass to the free end and repeat the hits.",
    frozenset({"clamp_rotation", "stiffness_loss"}): "Strike close to the clamp: the slope there shows a soft root.",
    frozenset({"gain_error", "position_error"}): "Exchange the suspect accelerometer with its neighbour and repeat.",
    frozenset({"shaker_mass", "stinger_moment"}): "Repeat the sines with the shaker at another point.",
    frozenset({"shaker_mass", "added_mass"}): "Take the shaker off and repeat the hits.",
    frozenset({"force_gain", "clock_error"}): "Calibrate the force transducer with a known mass on a string.",
    frozenset({"channel_skew", "trigger_delay"}): "Exchange the first and the last row of the converter and repeat.",
    frozenset({"thermal_drift", "clamp_rotation"}): "Repeat the first hits at the end.",
}


def next_experiment(verdict: Verdict, ranked: list[tuple[Fit, float]], campaign: Campaign) -> str:
    """One sentence on what to do next."""
    if verdict == "no_gap":
        return "None: the twin and the bench agree to within the noise."
    likely = [f for f, p in ranked if p > 0.05 and f.problem.candidates]
    if len(likely) > 1:
        first, second = ({c.effect for c in f.problem.candidates} for f in likely[:2])
        differ = frozenset(first ^ second)
        for pair, advice in SEPARATES.items():
            if pair <= differ:
                return advice
        return f"Separate {' from '.join(sorted(differ))}: strike at a point where only one of them moves."
    if verdict == "unknown":
        return _for_unknown(campaign)
    return "Put the effect into the simulated bench, or mend it on the real one, and repeat the campaign."


def _for_unknown(campaign: Campaign) -> str:
    levels = {b.level for b in campaign.blocks if b.test == "sine"}
    points = {b.drive_point for b in campaign.blocks if b.test == "impact"}
    if len(levels) < 2:
        return "Repeat the sines at a second level: does the bench answer in proportion to the force?"
    if len(points) < 3:
        return "Strike at more points: a gap in the beam changes the poles, one at the point of the hit does not."
    return "Repeat the sines at a third level, and the first hits at the end: level and time distinguish most effects."
