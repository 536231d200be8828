"""Parts of a test that each show all FRFs, to be held against one another."""

from collections.abc import Sequence

from modallab.frf.broadband import PERIODIC
from modallab.frf.joined import contiguous_blocks
from modallab.frf.sums import Estimator
from modallab.signals.signals import Signals


def least_blocks(signals: Sequence[Signals], estimator: Estimator) -> int:
    """How many blocks of a test have an FRF of their own.

    A block of one periodic force holds a whole period: one by itself will do, but for H2 and Hv, which need an average.
    Several take two blocks of each of as many waves.
    """
    first = signals[0]
    if first.block.test not in PERIODIC:
        return 2
    one = 1 if estimator == "H1" else 2
    return one if len(first.forces) == 1 else 2 * len(first.forces)


def split_blocks(signals: Sequence[Signals], count: int) -> list[list[Signals]]:
    """The blocks in so many parts of one size, in the order of time; what is left over at the end is in none.

    Several periodic forces are distinguished by their waves: there a part has its share of each, of about one size.
    """
    ordered = sorted(signals, key=lambda s: s.block.order)
    if len(ordered[0].forces) == 1 or ordered[0].block.test not in PERIODIC:
        each = len(ordered) // count
        return [ordered[k * each : (k + 1) * each] for k in range(count)]
    found: list[list[Signals]] = [[] for _ in range(count)]
    for run in contiguous_blocks(ordered):
        for place, one in enumerate(run):
            found[place * count // len(run)].append(one)
    return found
