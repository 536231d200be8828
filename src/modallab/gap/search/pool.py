"""The candidates worth a look after a fit: those of the bench, and those of the channels that stand out."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.gap.model.candidates import of_bench, of_channel, of_pairs, testable
from modallab.gap.model.fit import Fit, all_rows, softened
from modallab.gap.model.forward import forward
from modallab.gap.model.prefit import start
from modallab.gap.search.fitting import Bench, misfit
from modallab.twin.candidate import Candidate
from modallab.twin.effects import model_of

Array = NDArray[np.float64]


def pool(bench: Bench, fit: Fit) -> list[Candidate]:
    """The candidates worth a look after a fit: all of the bench, and those of the channels that stand out."""
    rig = bench.data.rig
    shares = [channel_share(fit)]
    if len(bench.poles):
        # A channel far off drags the fit with it; the beam that the poles show reveals it all the same.
        u = start(fit.problem.candidates, fit.u[bench.free.size :], bench.free, bench.poles).u
        shares.append(channel_share(replace(fit, u=u)))
    order = list(dict.fromkeys(int(i) for s in shares for i in np.argsort(s)[::-1][:2]))
    suspects = [bench.data.channels[i] for i in order]
    pairs = of_pairs(rig, tuple(sorted({bench.data.channels[i] for s in shares for i in np.argsort(s)[::-1][:3]})))
    found = of_bench(rig) + [c for s in suspects for c in of_channel(rig, s)] + pairs
    present = {(c.effect, c.place) for c in fit.problem.candidates}
    return [
        c
        for c in found
        if bench.allowed(c.effect)
        and (c.effect, c.place) not in present
        and not (model_of(c.effect).once and any(p.effect == c.effect for p in fit.problem.candidates))
        and testable(c, bench.data)
    ]


def channel_share(fit: Fit) -> Array:
    """(channels,) share of the relative misfit that stands in each channel, big responses no more than small ones."""
    twin, floor = fit.problem.twin(fit.u), misfit(fit.problem, fit.u)
    total = np.zeros(len(fit.problem.data.channels))
    for rows, y in zip(all_rows(fit.problem.data), forward(twin, fit.problem.data), strict=True):
        r = softened(rows, floor / 3).whiten(rows.y - y)
        total += np.sum(np.minimum(np.abs(r) ** 2, 400.0), axis=1)
    return total / max(float(np.sum(total)), 1e-300)
