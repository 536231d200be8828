"""The modal model in the paper's form (eqs. 13 and 14), with its uncertainty."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from modallab.core.frf import Frf
from modallab.core.frozen import ComplexArray, Frozen, RealArray, is_missing, is_not_stated
from modallab.core.units import Test
from modallab.core.versions import MODEL

Method = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]
"""Name of an estimator. Which there are, the identification knows; a stored model may name one of another time."""


class ScaleUncertainty(Frozen):
    """Relative uncertainty of the scale from the sensitivities, one standard deviation, the same in every mode.

    NaN or None (null in JSON) if no certificate or calibration states it. The sigmas of the model do not include it;
    they are those of the records' noise.

    Attributes:
        force: uncertainty of the force's sensitivity.
        responses: (outputs,) uncertainty of the responses' sensitivities.
        modal_constants: (outputs,) uncertainty of the modal constants.
        shapes: (outputs,) uncertainty of the shapes at unit modal mass; NaN without a driving point.
        modal_mass: uncertainty of the modal mass of a shape that is 1 at the driving point; None without one.
    """

    force: float | None
    responses: RealArray
    modal_constants: RealArray
    shapes: RealArray
    modal_mass: float | None


class Backbone(Frozen):
    """Amplitude dependence of the modes: values of each mode at each level, from the weakest to the strongest.

    Attributes:
        levels: (levels,) names.
        sensors: (modes,) output of each mode's amplitude.
        amplitude_m: (modes, levels) effective displacement in m.
        frequency_hz: (modes, levels)
        frequency_sigma_hz: (modes, levels)
        damping_ratio: (modes, levels)
        damping_sigma: (modes, levels)
    """

    levels: tuple[str, ...]
    sensors: tuple[str, ...]
    amplitude_m: RealArray
    frequency_hz: RealArray
    frequency_sigma_hz: RealArray
    damping_ratio: RealArray
    damping_sigma: RealArray


class ModalModel(Frozen):
    """Modes of a structure, from one test.

    The receptance is the sum over modes of A_r / (omega_r^2 - omega^2 + 2 j zeta_r omega_r omega), with the modal
    constant A_r,jk = phi_jr phi_kr at unit modal mass (eq. 13). The paper's loss factor is eta = 2 zeta.
    Arrays are sorted by frequency. Sigmas are one standard deviation, NaN (null in JSON) where not known.

    Attributes:
        method: the estimator.
        test: test of the records; None for FRFs of unknown origin.
        band_hz: band of the lines used.
        frequency_hz: (modes,) undamped natural frequency omega_r / 2 pi.
        damping_ratio: (modes,) zeta.
        frequency_sigma_hz: (modes,)
        damping_sigma: (modes,)
        outputs: (outputs,) channel names.
        output_points: (outputs,) points, None where unknown.
        input_points: (inputs,) drive points, None where unknown.
        modal_constants: (modes, outputs, inputs) complex, kg^-1; real for proportional damping.
        modal_constant_sigma: (modes, outputs, inputs) of the complex number.
        modal_constant_part_sigma: (modes, outputs, inputs), the real part that of the real part, the imaginary part
            that of the imaginary part; None where not known.
        residuals: (terms, outputs, inputs) real coefficients of s^p in the receptance of modes outside the band, for
            p in `residual_powers`, in m/N s^p.
        residual_powers: (terms,) powers of s.
        shapes: (modes, outputs) phi at unit modal mass, kg^-1/2; None if `shapes_unavailable`.
        shape_sigma: (modes, outputs) or None.
        shapes_unavailable: reason for missing shapes or modal mass, otherwise "".
        half_power: (modes,) damping ratio by the half-power rule from the same blocks; NaN if unreadable. Half the
            paper's delta-f / f.
        half_power_floor: (modes,) half-power reading for an undamped mode in a block of this length.
        notes: sentences on the identification.
        scale_uncertainty: uncertainty from the sensitivities; None if none is stated.
        operating_shapes: (modes, outputs) of unknown scale, 1 at the largest, if no force was measured; otherwise
            None.
        operating_shape_sigma: (modes, outputs) of the complex number, or None.
        backbone: amplitude dependence of the modes, if records of several levels show it.
        hit_shares: (modes, inputs, hits) share of each hit in the modal constants of its input; None without hits.
    """

    format_version: Literal[1] = MODEL
    method: Method
    test: Test | None = None
    band_hz: tuple[float, float]
    frequency_hz: RealArray
    damping_ratio: RealArray
    frequency_sigma_hz: RealArray
    damping_sigma: RealArray
    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    modal_constants: ComplexArray
    modal_constant_sigma: RealArray
    modal_constant_part_sigma: ComplexArray | None = None
    residuals: RealArray
    residual_powers: tuple[int, ...] = ()
    shapes: ComplexArray | None = None
    shape_sigma: RealArray | None = None
    shapes_unavailable: str = ""
    half_power: RealArray
    half_power_floor: RealArray
    notes: tuple[str, ...] = Field(default=())
    scale_uncertainty: ScaleUncertainty | None = Field(default=None, exclude_if=is_not_stated)
    operating_shapes: ComplexArray | None = Field(default=None, exclude_if=is_missing)
    operating_shape_sigma: RealArray | None = Field(default=None, exclude_if=is_missing)
    backbone: Backbone | None = Field(default=None, exclude_if=is_missing)
    hit_shares: RealArray | None = Field(default=None, exclude_if=is_missing)

    @property
    def n_modes(self) -> int:
        """Number of modes."""
        return len(self.frequency_hz)


@dataclass(frozen=True, eq=False, slots=True)
class Verification:
    """Measured against regenerated mobility, both through the same block.

    Attributes:
        measured: mobility from the test's blocks.
        regenerated: mobility of the model's response to the measured force, cut as the blocks were.
        untruncated: the model's own mobility on a fine grid, with no block at all.
        frac: (outputs, inputs) FRAC of measured against regenerated; of FRFs as imported in the quantity they came in.
    """

    measured: Frf
    regenerated: Frf
    untruncated: Frf
    frac: NDArray[np.float64]
