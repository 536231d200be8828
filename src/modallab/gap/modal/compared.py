"""What is compared: FRFs that two modal models stand for, on lines off the frequency axis.

At s = sigma + j omega an FRF is as smooth as if every mode had that much more damping. Two models of one structure can
be held against one another there while their frequencies still differ, and no noise is between the lines.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.gap.modal.errors import ERROR, sizes, weights
from modallab.gap.modal.matching import in_common
from modallab.gap.modal.same_form import in_form_of
from modallab.gap.modal.weights import Weights
from modallab.modification.freedoms import freedoms_of
from modallab.modification.mesh import Mesh
from modallab.modification.shapes import Shapes, shapes_of
from modallab.modification.synthesis import beside, synthesised

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

SMOOTH = 0.01
"""Sigma over omega: the damping ratio that every mode seems to have more."""
SMOOTHER = (0.2, 0.05)
"""The same where a search begins, and then: modes that have moved by that much still overlap with where they were."""
ABOUT = (-1.5, 0.0, 1.5)
"""Lines about each mode, in units of that."""
CLOSE = 0.05
"""Modes whose frequencies differ by less are close."""
BETWEEN = 5
"""Lines evenly over the band."""


@dataclass(frozen=True, eq=False, slots=True)
class Compared:
    """The reference as a model with freedoms, and the bench's FRFs.

    Attributes:
        rig: of the bench.
        model: the reference.
        bench: what the bench's model is.
        shapes: of the reference.
        out_psi: (outputs, modes) of the reference, complex as it is, along the freedoms.
        into_psi: (inputs, modes), with the phase of the chain.
        out_slopes: (outputs, 2, modes) along the surface, 1/m.
        into_slopes: (inputs, 2, modes).
        s: (lines,) complex frequencies.
        outside: (lines, outputs, inputs) all that the reference holds beside the products of its shapes: what lies
            outside the band; m/N.
        measured: (lines, outputs, inputs) the bench's receptances.
        weights: of misfits.
        error: share of its size by which a line is off by itself, (outputs, inputs) or of all FRFs.
    """

    rig: Rig
    model: ModalModel
    bench: ModalModel
    shapes: Shapes
    out_psi: Complex
    into_psi: Complex
    out_slopes: Complex
    into_slopes: Complex
    s: Complex
    outside: Complex
    measured: Complex
    weights: Weights
    error: Real | float = ERROR

    def off_by(self, error: Real) -> "Compared":
        """With errors of the lines that were measured, (outputs, inputs)."""
        own = weights(self.model, self.bench, self.s, self.measured, error)
        return replace(self, error=error, weights=own)

    def thinned(self, lines: slice) -> "Compared":
        """On some of the lines."""
        s, measured = self.s[lines], self.measured[lines]
        own = weights(self.model, self.bench, s, measured, self.error)
        return replace(self, s=s, outside=self.outside[lines], measured=measured, weights=own)

    @property
    def close_pairs(self) -> list[tuple[int, int]]:
        """Modes of the reference that a small change turns into one another, and their damping with them."""
        omega = self.model.frequency_hz
        return [(r, q) for r in range(len(omega)) for q in range(r) if abs(omega[r] / omega[q] - 1) < CLOSE]

    def shifted(self, output: int, along_m: Real, off: Real) -> Complex:
        """(modes,) by how much the shapes change where a sensor sits (2,) metres along the tangents from its point.

        `off` (modes,) says by how many deviations the shapes there are other than what the points tell.
        """
        freedom = freedoms_of(self.model, self.rig)[0][output]
        places = np.stack([along_m @ self.shapes.tangents(freedom), np.zeros(3)])
        there, here = self.shapes.moved(freedom, places)
        unknown = off * self.shapes.uncertain(freedom, places[:1])[0]
        return np.asarray(there - here + unknown)

    @property
    def sizes(self) -> Real:
        """(lines, outputs, inputs) of the measured FRFs, the small ones as if they were a share of their line's rms."""
        return sizes(self.measured)

    @property
    def local_compliance(self) -> float:
        """Typical compliance at a driving point of the modes outside the band, m/N; 0 where nothing is known."""
        outputs, inputs = freedoms_of(self.model, self.rig)
        if 0 not in self.model.residual_powers:
            return 0.0
        static = self.model.residuals[self.model.residual_powers.index(0)]
        known = [static[o, i] for o, f in enumerate(outputs) for i, g in enumerate(inputs) if f == g]
        return max(float(np.median(known)), 0.0) if known else 0.0


def compared(
    reference: ModalModel,
    bench: ModalModel,
    rig: Rig,
    smooth: float = SMOOTH,
    mesh: Mesh | None = None,
    own: Rig | None = None,
) -> Compared:
    """Both models on common lines, for the outputs and inputs that both have; between the points by the mesh, if any.

    Args:
        reference: of the rig `own`, or of the bench's where that is None.
        bench: of the rig `rig`.
        rig: the bench's, with its tolerances.
        smooth: sigma over omega of the lines.
        mesh: the reference's shapes at nodes between the points.
        own: the reference's rig.

    Raises:
        DataError: they share no band, no output or no input.
    """
    low = max(reference.band_hz[0], bench.band_hz[0])
    high = min(reference.band_hz[1], bench.band_hz[1])
    if not low < high:
        raise DataError(
            f"the reference covers {reference.band_hz} Hz, the bench {bench.band_hz} Hz: nothing in common",
            where=rig.name,
            remedy="identify both in one band",
        )
    reference, bench = in_common(reference, own or rig, bench, rig)
    reference = in_form_of(bench, reference)
    shapes = shapes_of(reference, rig, mesh)
    outputs, inputs = freedoms_of(reference, rig)
    s = _lines(bench, max(low, 0.3 * float(reference.frequency_hz[0])), high, smooth)
    measured = synthesised(bench, s)
    out_psi = np.array([shapes.seen[:, shapes.index(f)] for f in outputs])
    into_psi = np.array([shapes.driven[:, shapes.index(f)] for f in inputs]) * shapes.turn
    return Compared(
        rig=rig,
        model=reference,
        bench=bench,
        shapes=shapes,
        out_psi=out_psi,
        into_psi=into_psi,
        out_slopes=np.array([shapes.slopes(f) for f in outputs]),
        into_slopes=np.array([shapes.slopes(f) for f in inputs]) * shapes.turn,
        s=s,
        outside=beside(reference, s, out_psi, into_psi),
        measured=measured,
        weights=weights(reference, bench, s, measured),
    )


def _lines(bench: ModalModel, low: float, high: float, smooth: float) -> Complex:
    modes = bench.frequency_hz
    hz = np.concatenate([np.linspace(low, high, BETWEEN), *(modes * (1 + a * smooth) for a in ABOUT)])
    hz = np.unique(np.round(hz[(hz >= low) & (hz <= high)], 6))
    return np.asarray(2 * np.pi * hz * (smooth + 1j))
