"""The paper's estimator: peaks of the mobility, half-power damping, shapes from the mobility at the peaks."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frf
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.units import Test
from modallab.frf.estimate import convert_frf
from modallab.identification.estimator import Estimator
from modallab.identification.model.modal_mass import unit_mass_shapes
from modallab.identification.start.half_power import (
    HalfPowerPeak,
    find_peaks,
    half_power_pole,
    poles_of_peaks,
    summed_amplitude,
)


def identify_peaks(frf: Frf, test: Test | None, floor_lines: float = 0.886) -> ModalModel:
    """Modal model by peak search and half-power (the paper's step D).

    At a well separated resonance the mobility of eq. 14 is Y = A / (eta omega), eta = 2 zeta. The frequency is that of
    the peak's line, known to half a line at best: its sigma is that of a uniform error, line spacing / sqrt(12).

    Args:
        frf: any quantity, lines ascending.
        test: the test it came from.
        floor_lines: half-power width, in lines, of an undamped mode in a block without window.

    Raises:
        DataError: the FRF is not finite, its lines do not ascend, or it has no phase.
        IdentificationError: no peak stands out.
    """
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=False)
    mobility = convert_frf(frf, "mobility")
    f = mobility.frequency_hz
    peaks = find_peaks(f, summed_amplitude(mobility))
    _require_peaks(peaks, f)
    index = np.array([p.line for p in peaks])
    read = np.array([p.damping_ratio for p in peaks])
    # Part of the width is that of an exponential window, if there was one.
    zeta = read - frf.damping_shift / (2 * np.pi * f[index])
    at = np.moveaxis(mobility.values[..., index], -1, 0)
    usable = np.where(np.isfinite(read), read, 0.0)
    constants = 2 * usable[:, None, None] * 2 * np.pi * f[index][:, None, None] * at.real
    spacing = np.maximum(f[np.minimum(index + 1, f.size - 1)] - f[index], f[index] - f[np.maximum(index - 1, 0)])
    floor = floor_lines * spacing / (2 * f[index])
    shapes = unit_mass_shapes(constants.astype(complex), np.abs(constants) + 1e-30, frf.output_points, frf.input_points)
    unknown: NDArray[np.float64] = np.full(constants.shape, np.nan)
    return ModalModel(
        method="peak",
        test=test,
        band_hz=(float(f[0]), float(f[-1])),
        frequency_hz=f[index],
        damping_ratio=zeta,
        frequency_sigma_hz=spacing / np.sqrt(12),
        damping_sigma=np.full(index.size, np.nan),
        outputs=frf.outputs,
        output_points=frf.output_points,
        input_points=frf.input_points,
        modal_constants=constants.astype(complex),
        modal_constant_sigma=unknown,
        residuals=np.zeros((0, *constants.shape[1:])),
        shapes=shapes.phi,
        shapes_unavailable=shapes.unavailable,
        half_power=read,
        half_power_floor=floor,
        notes=("Half-power reads the resolution of the block wherever its reading is near the floor beside it.",),
    )


def _require_peaks(peaks: Sequence[HalfPowerPeak], f: NDArray[np.float64]) -> None:
    if not peaks:
        raise IdentificationError(
            f"no peak stands out by 6 dB between {f[0]:.4g} and {f[-1]:.4g} Hz",
            remedy="widen the band, or use more lines: a peak needs some on either side",
        )


ESTIMATOR = Estimator(
    name="peak",
    title="peak search and half-power rule",
    called="the half-power rule",
    description="peak search and the half-power rule, as in the paper",
    source='Ewins, "Modal Testing", 2nd ed. (2000), section 4.3',
    grid="any",
    refined=False,
    poles=lambda frf: poles_of_peaks(frf, half_power_pole),
    model=identify_peaks,
)
