"""Records of drawn structures with damaged samples: named, and never a mode."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from drawn import drawn, modes, modes_or_said
from known import Known, Record, case
from text_cases import save

HEAD = "time [s],force [N],a1 [m/s^2],a2 [m/s^2]"
DRIVEN = ("--drive-point", "1")
LEFT_OUT = "(?i)left out|no record|fault|flat|held|repeat|drop|single|straight|drift|dead|noise"


def written(folder: Path, records: list[Record]) -> tuple[str, ...]:
    names = []
    for k, r in enumerate(records, 1):
        rows = [",".join([f"{i / r.rate:.9f}", *(f"{v:.9g}" for v in row)]) for i, row in enumerate(r.rows.T)]
        names += save(folder, [HEAD, *rows], name=f"hit{k}.csv")
    return tuple(names)


def damaged(name: str, harm: Callable[[Record], Record], says: str, hits: int = 1, which: int = 0, **more) -> Callable:
    """A case of so many hits, one of which is harmed."""

    def write(folder: Path) -> Known:
        d = drawn(name)
        records = [d.hit(k + 1) for k in range(hits)]
        records[which] = harm(records[which])
        check = modes(d) if hits > 1 else modes_or_said(d, LEFT_OUT)
        return Known(written(folder, records), check=check, says=says, rejected=says, **more)

    return write


def put(name: str, about: str, *args, **kwargs) -> None:
    write = damaged(name, *args, **kwargs)
    write.__name__, write.__doc__ = name, about
    case("damaged")(write)


def changed(r: Record, **rows: np.ndarray) -> Record:
    return Record(*(rows.get(n, getattr(r, n)) for n in ("force", "a1", "a2")), r.rate)


def soft_tops(r: Record) -> Record:
    """Tops with the noise of one step of a converter on them."""
    top = 0.5 * abs(r.a1).max()
    step = top / 8000
    noise = np.random.default_rng(5).integers(-1, 2, len(r.a1)) * step
    cut = np.where(abs(r.a1) > top, np.sign(r.a1) * top + noise, r.a1)
    return changed(r, a1=np.round(cut / step) * step)


def held(r: Record) -> Record:
    return changed(r, a2=np.repeat(r.a2[::4], 4)[: len(r.a2)])


def impossible_value(r: Record) -> Record:
    a = r.a1.copy()
    a[len(a) // 2] = 1e200
    return changed(r, a1=a)


def dropped(r: Record) -> Record:
    a = r.a2.copy()
    first = int(0.1 * r.rate)
    a[first : first + int(0.04 * r.rate)] = 0
    return changed(r, a2=a)


def dead(r: Record) -> Record:
    step = abs(r.a1).max() / 3e4
    return changed(r, a1=step * np.random.default_rng(6).integers(-1, 2, len(r.a1)))


def drifting(r: Record) -> Record:
    t = np.arange(len(r.a1)) / r.rate
    return changed(r, a1=r.a1 + 20 * abs(r.a1).max() * (1 - np.exp(-t / 0.5)))


def struck(r: Record) -> Record:
    a = r.a2.copy()
    a[[301, 777, 1203]] += 10 * abs(a).max() * np.array([1, -1, 1])
    return changed(r, a2=a)


def wrapped(r: Record) -> Record:
    """int16 that overflows: beyond the range it begins again at the other end."""
    top = 0.6 * abs(r.a1).max()
    counts = np.round(r.a1 / top * 32767).astype("i8")
    return changed(r, a1=((counts + 32768) % 65536 - 32768) * top / 32767)


def buffer_twice(r: Record) -> Record:
    """A buffer of 128 samples is written twice in place of the next, in all channels."""
    rows = [row.copy() for row in r.rows]
    for row in rows:
        row[384:512] = row[256:384]
    return Record(*rows, r.rate)


def force_cut(r: Record) -> Record:
    return changed(r, force=np.minimum(r.force, 0.55 * r.force.max()))


put("soft_flat_tops", "Flat tops with the converter's last step on them.", soft_tops, "(?i)flat|range|top")
put("one_sensor_held", "One channel is a slower converter's: each value four times.", held, "(?i)held|repeat|slower")
put(
    "a_value_of_1e200",
    "One value of 1e200 in one of three hits.",
    impossible_value,
    "(?i)1e\\+?200|single|value|beyond",
    3,
    1,
)
put("cable_for_40_ms", "One channel is 0 for 40 ms in one of three hits.", dropped, "stands still", 3, 2)
put(
    "dead_but_noisy", "A channel without a sensor: its converter's last step only.", dead, "(?i)dead|no signal|a1|noise"
)
put("warming_sensor", "A zero that drifts by twenty times the signal.", drifting, "(?i)drift|zero|rest|a1")
put("static_discharges", "Three single samples of ten times the largest.", struck, "neighbouring samples")
put(
    "counts_that_wrap",
    "Overflow of whole numbers: beyond the range the other end.",
    wrapped,
    "(?i)wrap|jump|overflow|range|single|top",
)
put("a_buffer_twice", "128 samples of all channels stand twice.", buffer_twice, "(?i)repeat|twice|again|jump")
put("force_out_of_range", "The force of one of three hits has a flat top.", force_cut, "(?i)flat|top|range", 3, 0)
