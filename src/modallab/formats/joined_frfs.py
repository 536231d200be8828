"""FRFs of several files as one matrix."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.frf import Frf

_ROUNDING = 1e-6
"""Relative, of lines that files write with their own digits."""


def joined_frfs(frfs: Sequence[Frf]) -> tuple[Frf, ...]:
    """FRFs of several files as one matrix, if they fill it over the same lines, each pair once; else as given."""
    outputs = tuple(dict.fromkeys(pair for frf in frfs for pair in zip(frf.outputs, frf.output_points, strict=True)))
    inputs = tuple(dict.fromkeys(point for frf in frfs for point in frf.input_points))
    places = [(o, i) for frf in frfs for o in frf.outputs for i in frf.input_points]
    if len(frfs) < 2 or not _are_alike(frfs) or not len(set(places)) == len(places) == len(outputs) * len(inputs):
        return tuple(frfs)
    names = [name for name, _ in outputs]
    shape = (len(names), len(inputs), frfs[0].frequency_hz.size)
    values, coherence = np.empty(shape, np.complex128), np.empty(shape)
    for frf in frfs:
        at = np.ix_([names.index(o) for o in frf.outputs], [inputs.index(i) for i in frf.input_points])
        values[at] = frf.values
        coherence[at] = 1.0 if frf.coherence is None else frf.coherence
    whole = replace(frfs[0], values=values, outputs=tuple(names), output_points=tuple(p for _, p in outputs))
    return (replace(whole, input_points=inputs, coherence=None if frfs[0].coherence is None else coherence),)


def _are_alike(frfs: Sequence[Frf]) -> bool:
    """Whether FRFs are of one kind, over the same lines, without numbers of each that a matrix would lose."""
    first = frfs[0]
    kinds = {
        (f.quantity, f.damping_shift, f.frequency_hz.size, f.coherence is None, f.variance is None, f.averages)
        for f in frfs
    }
    same = len(kinds) == 1 and first.variance is None and not first.averages
    return same and all(np.allclose(f.frequency_hz, first.frequency_hz, rtol=_ROUNDING, atol=0) for f in frfs)
