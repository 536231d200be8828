"""What is compared: FRFs that two modal models stand for, on lines off the frequency axis.

At s = sigma + j omega an FRF is as smooth as if every mode had that much more damping. Two models of one structure can
be held against one another there while their frequencies still differ, and no noise is between the lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE
from modallab.gap.modal.beside_modes import BesideModes
from modallab.gap.modal.errors import sizes, weights
from modallab.gap.modal.matching import Side, in_common
from modallab.gap.modal.narrower import in_band
from modallab.gap.modal.off_axis import Means
from modallab.gap.modal.rigid import with_rigid_mode
from modallab.gap.modal.state import AttachedElement
from modallab.gap.modal.weights import Weights
from modallab.modification.freedoms import Freedom, freedoms_of
from modallab.modification.frfs import receptance_of_modes, receptances_of_model
from modallab.modification.mesh import Mesh
from modallab.modification.shapes import FreedomShapes, shapes_of
from modallab.updating.elements import COMPUTED

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
        response_factors: (outputs, modes) of the reference, complex as it is, along the freedoms.
        force_factors: (inputs, modes), with the phase of the chain.
        response_slopes: (outputs, 2, modes) along the surface, 1/m.
        force_slopes: (inputs, 2, modes); (1, 2 modes, modes) of an unknown force, which may do anything to each mode.
        s: (lines,) complex frequencies.
        outside: all that the reference holds beside the products of its shapes: what lies outside the band, and what
            its model leaves of the measured FRFs.
        known: (lines, outputs, inputs) the reference's receptances.
        measured: (lines, outputs, inputs) the bench's.
        frfs: of the reference, where those of both were measured.
        noise: (lines, lines, outputs, inputs) covariance of the noise of both where FRFs are compared, else None.
        weights: of misfits.
    """

    rig: Rig
    model: ModalModel
    bench: ModalModel
    shapes: FreedomShapes
    response_factors: Complex
    force_factors: Complex
    response_slopes: Complex
    force_slopes: Complex
    s: Complex
    outside: BesideModes
    known: Complex
    measured: Complex
    frfs: Means | None
    noise: Complex | None
    weights: Weights

    def scaled(self, lines: Real | float, along: Real | float) -> "Compared":
        """With lines that are off by a factor more, and what goes along whole FRFs; as of `weights`."""
        own = weights(self.model, self.bench, self.s, self.measured, self.noise, lines, along)
        return replace(self, weights=own)

    def noisier(self, factor: float) -> "Compared":
        """With noise of the measured FRFs larger by a factor; as it is where none were."""
        if self.noise is None or factor == 1:
            return self
        noise = factor**2 * self.noise
        return replace(self, noise=noise, weights=weights(self.model, self.bench, self.s, self.measured, noise))

    def thinned(self, lines: slice) -> "Compared":
        """On some of the lines."""
        s, measured = self.s[lines], self.measured[lines]
        noise = None if self.noise is None else self.noise[lines, lines]
        own = weights(self.model, self.bench, s, measured, noise)
        parts = {"s": s, "outside": self.outside.thinned(lines), "known": self.known[lines], "measured": measured}
        frfs = None if self.frfs is None else self.frfs.thinned(lines)
        return replace(self, **parts, frfs=frfs, noise=noise, weights=own)

    def by_lines(self, hung: AttachedElement) -> AttachedElement:
        """What hangs at a driven point where a sensor stands, coupled line by line if the FRFs were measured."""
        if self.frfs is None:
            return hung
        return replace(hung, extra=self.frfs.changed(hung.coupled) - hung.coupled(self.known, self.s))

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
        there, here = self.shapes.shapes_beside(freedom, places)
        unknown = off * self.shapes.uncertainty_beside(freedom, places[:1])[0]
        return np.asarray(there - here + unknown)

    def rows_of(self, output: int, along_m: Real) -> Real:
        """(outputs,) by which FRFs of other outputs come into that of a sensor that sits (2,) metres from its point.

        Between sensors FRFs go along as shapes do. Where a mesh tells the shapes, none come in.
        """
        freedoms = freedoms_of(self.model, self.rig)[0]
        freedom = freedoms[output]
        same = [f for f in self.shapes.freedoms if f[1] == freedom[1]]
        between, found = self.shapes.between[freedom[1]], np.zeros(len(freedoms))
        if len(between.known) != len(same):
            return found
        at = self.shapes.at_m[self.shapes.index(freedom)]
        # What lies outside the band is no mode: its waves are about as long as theirs.
        there, here = between.interpolation_matrix(np.stack([at + along_m @ self.shapes.tangents(freedom), at])).mean(
            axis=0
        )
        share = dict(zip(same, there - here, strict=True))
        for o, f in enumerate(freedoms):
            if freedoms.index(f) == o:
                found[o] = share.get(f, 0.0)
        return found

    @property
    def power(self) -> int:
        """Times the outputs differentiate the displacement."""
        quantities = {channel.name: channel.quantity for channel in self.rig.channels}
        return DERIVATIVE.get(quantities[self.model.outputs[0].split("@")[0]], 0)

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
    reference: Side,
    bench: Side,
    rig: Rig,
    smooth: float = SMOOTH,
    mesh: Mesh | None = None,
    own: Rig | None = None,
) -> Compared:
    """Both on common lines, for the outputs and inputs that both have; between the points by the mesh, if any.

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
    low, high = band_of(reference.model, bench.model, rig)
    before, after = in_common(reference, own or rig, bench, rig)
    # FRFs count where both sides have them: those of one alone would pass for a gap.
    both = None not in (before.measured, after.measured)
    model, other = before.model, after.model
    if not both:
        model, other = (in_band(m, (low, high)) for m in (model, other))
    lowest = max(low, 0.3 * float(model.frequency_hz[0]))
    model = with_rigid_mode(model, rig)
    shapes = shapes_of(model, rig, mesh)
    outputs, inputs = freedoms_of(model, rig)
    s = _lines(other, lowest, high, smooth)
    response_factors = np.array([shapes.seen[:, shapes.index(f)] for f in outputs])
    force_factors = np.array([shapes.driven[:, shapes.index(f)] for f in inputs]) * shapes.turn
    means = _means(s, before, after)

    def beside(s: Complex) -> Complex:
        whole = receptances_of_model(model, s) if means is None else means[0].at(s).receptances
        return whole - np.einsum("lr,or,ir->loi", receptance_of_modes(model, s), response_factors, force_factors)

    if means is None:
        known, measured, noise = receptances_of_model(model, s), receptances_of_model(other, s), None
    else:
        s, (known, measured) = means[0].s, (m.receptances for m in means)
        noise = means[0].noise() + means[1].noise()
    return Compared(
        rig=rig,
        model=model,
        bench=other,
        shapes=shapes,
        response_factors=response_factors,
        force_factors=force_factors,
        response_slopes=np.array([shapes.slopes(f) for f in outputs]),
        force_slopes=_force_slopes(shapes, inputs, force_factors, other),
        s=s,
        outside=BesideModes.of(beside, s),
        known=known,
        measured=measured,
        # What hangs on a computed reference is not coupled line by line: its resonances are not the bench's.
        frfs=None if means is None or model.method == COMPUTED else means[0],
        noise=noise,
        weights=weights(model, other, s, measured, noise),
    )


def _force_slopes(
    shapes: FreedomShapes, inputs: Sequence[Freedom], force_factors: Complex, bench: ModalModel
) -> Complex:
    if bench.operating_shapes is not None:
        each = np.diag(force_factors[0])
        return np.concatenate([each, 1j * each])[None]
    return np.array([shapes.slopes(f) for f in inputs]) * shapes.turn


def band_of(reference: ModalModel, bench: ModalModel, rig: Rig) -> tuple[float, float]:
    """The band that both models cover, Hz.

    Raises:
        DataError: there is none.
    """
    low = max(reference.band_hz[0], bench.band_hz[0])
    high = min(reference.band_hz[1], bench.band_hz[1])
    if not low < high:
        raise DataError(
            f"the reference covers {reference.band_hz} Hz, the bench {bench.band_hz} Hz: nothing in common",
            where=rig.name,
            remedy="identify both in one band",
        )
    return low, high


def _lines(bench: ModalModel, low: float, high: float, smooth: float) -> Complex:
    modes = bench.frequency_hz
    hz = np.concatenate([np.linspace(low, high, BETWEEN), *(modes * (1 + a * smooth) for a in ABOUT)])
    hz = np.unique(np.round(hz[(hz >= low) & (hz <= high)], 6))
    return np.asarray(2 * np.pi * hz * (smooth + 1j))


def _means(s: Complex, before: Side, after: Side) -> tuple[Means, Means] | None:
    """Of the FRFs of both, near s, where both were measured."""
    if before.measured is None or after.measured is None:
        return None
    omega, wanted = np.asarray(s.imag, np.float64), np.asarray(s.real, np.float64)
    each = np.array([of.sigma_at(omega, wanted) for of in (before.measured, after.measured)])
    there = np.asarray((each.max(axis=0) + 1j * omega)[np.all(each > 0, axis=0)])
    return before.measured.means_at(there), after.measured.means_at(there)
