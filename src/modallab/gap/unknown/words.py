"""Learned elements in words, with their numbers and units."""

from collections.abc import Callable, Mapping, Sequence

from modallab.core.described import Learned
from modallab.core.rig import Rig

Numbers = Mapping[str, float]


def said(learned: Sequence[Learned], rig: Rig) -> str:
    """What they behave like, as the end of a sentence: "a spring of 120 N/m to ground at 0.379 m"."""
    return " and ".join(f"{_SAID[one.element](one.parameters)}{_at(one, rig)}" for one in learned)


def _at(one: Learned, rig: Rig) -> str:
    x, row = one.place.get("x_m"), one.place.get("channel")
    if x is not None:
        return f" at {x:.3f} m"
    if row == "all":
        return " on all accelerometers"
    return f" on {rig.channels[int(row)].name}" if row is not None else ""


def _point(law: Numbers) -> str:
    parts: list[str] = []
    if "hung_m" in law:
        grams = 1e3 * law["hung_m"]
        parts.append(f"a mass of {grams:.4g} g on a spring with a resonance of its own at {law['hung_hz']:.4g} Hz")
    if "k" in law:
        parts.append(f"a spring of {law['k']:.4g} N/m to ground")
    if "c" in law:
        parts.append(f"a damper of {law['c']:.4g} N s/m to ground")
    if "m" in law:
        parts.append(f"a mass of {1e3 * law['m']:.4g} g")
    return " and ".join(parts)


def _beam(law: Numbers) -> str:
    parts: list[str] = []
    if "tension" in law:
        pull = "pull" if law["tension"] > 0 else "push"
        parts.append(f"a {pull} of {abs(law['tension']):.4g} N along the beam's axis")
    if "bedding" in law:
        parts.append(f"a stiffness of {law['bedding']:.4g} N/m to ground on each metre of the beam")
    return " and ".join(parts)


def _filter(law: Numbers) -> str:
    parts: list[str] = []
    if "gain" in law:
        parts.append(f"a factor of {law['gain']:.4g}")
    if "delay" in law:
        parts.append(f"a delay of {1e3 * law['delay']:.4g} ms")
    if "low_pass_hz" in law:
        parts.append(f"a first-order low-pass at {law['low_pass_hz']:.4g} Hz")
    if "high_pass_hz" in law:
        parts.append(f"a first-order high-pass at {law['high_pass_hz']:.4g} Hz")
    if "mount_hz" in law:
        parts.append(f"a mount with a resonance at {law['mount_hz']:.4g} Hz")
    return " and ".join(parts)


def _curve(law: Numbers) -> str:
    shape = f", with a knee of power {law['power']:.3g}," if "power" in law else ""
    for name in ("tanh_v", "knee_v"):
        if name in law:
            return f"a saturation that levels off at {law[name]:.4g} V{shape}"
    for name in ("tanh_share", "knee_share"):
        if name in law:
            return f"a saturation that levels off at {law[name]:.4g} times each record's own peak{shape}"
    terms = [f"{law[n]:.3g} u^{p}" for n, p in (("square", 2), ("cubic", 3)) if n in law]
    return f"a bent scale, u + {' + '.join(terms)} of u in V,"


def _hold(law: Numbers) -> str:
    instead = "the one before" if law["kept"] else "0"
    return f"a loss of {law['share']:.2%} of the samples, with {instead} in their place,"


_SAID: dict[str, Callable[[Numbers], str]] = {
    "point_law": _point,
    "beam_law": _beam,
    "row_filter": _filter,
    "row_curve": _curve,
    "row_hold": _hold,
}
