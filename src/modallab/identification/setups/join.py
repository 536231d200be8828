"""One modal model of several set-ups: poles averaged, modal constants side by side."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.identification.model.modal_mass import unit_mass_shapes
from modallab.identification.setups.compare import ComparedSetUp
from modallab.identification.setups.found import SetUpModel, joined_name

Places = NDArray[np.int64]


def join_setups(found: Sequence[SetUpModel], modes: Places, compared: Sequence[ComparedSetUp]) -> ModalModel:
    """One model of all set-ups; outputs are named `name@point`.

    Where frequencies agree within their sigmas, their mean is weighted by these; where they do not, the scatter between
    set-ups is estimated, weighs in, and is added to the sigma (DerSimonian and Laird, Controlled Clinical Trials 7,
    1986): the result is that of any one set-up, not of their mean alone. A mode that a sensor that stays
    reads otherwise in a set-up is scaled there to the one that it was compared with.

    Args:
        found: at least two set-ups, struck at the same points.
        modes: (set-ups, modes) places of the same modes.
        compared: of each set-up.

    Raises:
        DataError: they were struck at different points.
    """
    models = [item.model for item in found]
    require_same_points([(item.name, item.model.input_points) for item in found])
    frequency, frequency_sigma = weighted_mean(*_joined_poles(models, modes, "frequency"))
    damping, damping_sigma = weighted_mean(*_joined_poles(models, modes, "damping"))
    names, points = _joined_outputs(found)
    constants, sigma = _joined_constants(found, modes, [_scale_of_setup(item) for item in compared], names)
    powers, residuals = _joined_residuals(found, names)
    shapes = unit_mass_shapes(constants, sigma, points, models[0].input_points)
    return ModalModel(
        method=models[0].method,
        test=models[0].test,
        band_hz=(max(m.band_hz[0] for m in models), min(m.band_hz[1] for m in models)),
        frequency_hz=frequency,
        damping_ratio=damping,
        frequency_sigma_hz=frequency_sigma,
        damping_sigma=damping_sigma,
        outputs=names,
        output_points=points,
        input_points=models[0].input_points,
        modal_constants=constants,
        modal_constant_sigma=sigma,
        residuals=residuals,
        residual_powers=powers,
        shapes=shapes.phi,
        shape_sigma=shapes.sigma,
        shapes_unavailable=shapes.unavailable,
        half_power=np.median([m.half_power[at] for m, at in zip(models, modes, strict=True)], axis=0),
        half_power_floor=np.median([m.half_power_floor[at] for m, at in zip(models, modes, strict=True)], axis=0),
        notes=_notes_on_setups(found, modes, compared),
        hit_shares=None if models[0].hit_shares is None else models[0].hit_shares[modes[0]],
    )


def require_same_points(struck: Sequence[tuple[str, Sequence[int | None]]]) -> None:
    """Reject set-ups that were struck at different points.

    Args:
        struck: name of each set-up, and its points in their order.

    Raises:
        DataError: they differ.
    """
    first, points = struck[0]
    for name, others in struck[1:]:
        if tuple(others) != tuple(points):
            raise DataError(
                f"set-up {first} was struck at {_points_in_words(points)}, set-up {name} at {_points_in_words(others)}",
                remedy="strike the same points, in the same order, in every set-up; or identify each by itself",
            )


def _points_in_words(points: Sequence[int | None]) -> str:
    return "no point that is known" if None in points or not points else f"points {', '.join(map(str, points))}"


def weighted_mean(values: Real, sigmas: Real) -> tuple[Real, Real]:
    """The mean of (set-ups, modes), and its sigma; a set-up of infinite sigma says nothing.

    That is the sigma of the best set-up, since what is common to all, such as errors of the model, does not average
    out, and the scatter between set-ups, which is 0 where they agree.
    """
    weight = 1 / sigmas**2
    mean = np.sum(weight * values, axis=0) / weight.sum(axis=0)
    excess = np.sum(weight * (values - mean) ** 2, axis=0) - (np.isfinite(sigmas).sum(axis=0) - 1)
    between = np.maximum(excess, 0) / (weight.sum(axis=0) - np.sum(weight**2, axis=0) / weight.sum(axis=0))
    weight = 1 / (sigmas**2 + between)
    return np.sum(weight * values, axis=0) / weight.sum(axis=0), np.sqrt(sigmas.min(axis=0) ** 2 + between)


def _joined_poles(models: Sequence[ModalModel], modes: Places, which: str) -> tuple[Real, Real]:
    pairs = [
        (m.frequency_hz, m.frequency_sigma_hz) if which == "frequency" else (m.damping_ratio, m.damping_sigma)
        for m in models
    ]
    values = np.array([value[at] for (value, _), at in zip(pairs, modes, strict=True)])
    sigmas = np.array([sigma[at] for (_, sigma), at in zip(pairs, modes, strict=True)])
    # Poles of an estimator alone have no sigma: then all weigh the same, and their scatter is all that is known.
    return values, np.where(np.isfinite(sigmas), sigmas, 1e-9 * np.abs(values))


def _joined_outputs(found: Sequence[SetUpModel]) -> tuple[tuple[str, ...], tuple[int | None, ...]]:
    seen = {joined_name(name, point): point for item in found for name, point in item.standing.items()}
    ordered = sorted(seen.items(), key=lambda pair: (pair[1] is None, pair[1] or 0))
    return tuple(name for name, _ in ordered), tuple(point for _, point in ordered)


def _rows_of_setup(item: SetUpModel, names: Sequence[str]) -> list[int]:
    return [names.index(joined_name(name, point)) for name, point in item.standing.items()]


def _scale_of_setup(item: ComparedSetUp) -> Real:
    """(modes,) by what the modal constants of a set-up are divided."""
    # Two sensors at exchanged points differ in gain, and a mass that moved changes a shape at both.
    return np.where(item.ratio_off & item.stays, item.ratio, 1.0)


def _joined_constants(
    found: Sequence[SetUpModel], modes: Places, scales: Sequence[Real], names: Sequence[str]
) -> tuple[NDArray[np.complex128], Real]:
    """(modes, outputs, inputs); what several set-ups have is averaged by its sigmas."""
    shape = (modes.shape[1], len(names), len(found[0].model.input_points))
    total: NDArray[np.complex128] = np.zeros(shape, dtype=np.complex128)
    weight = np.zeros(shape)
    for item, at, scale in zip(found, modes, scales, strict=True):
        rows, by = _rows_of_setup(item, names), scale[:, None, None]
        a, s = item.model.modal_constants[at] / by, item.model.modal_constant_sigma[at] / np.abs(by)
        own = 1 / np.where(np.isfinite(s) & (s > 0), s, 1.0) ** 2
        total[:, rows] += own * a
        weight[:, rows] += own
    return total / weight, 1 / np.sqrt(weight)


def _joined_residuals(found: Sequence[SetUpModel], names: Sequence[str]) -> tuple[tuple[int, ...], Real]:
    powers = sorted({power for item in found for power in item.model.residual_powers})
    terms = np.zeros((len(powers), len(names), len(found[0].model.input_points)))
    for item in reversed(found):
        rows = _rows_of_setup(item, names)
        terms[:, rows] = 0.0
        for power, term in zip(item.model.residual_powers, item.model.residuals, strict=True):
            terms[powers.index(power), rows] = term
    return tuple(powers), terms


def _notes_on_setups(found: Sequence[SetUpModel], modes: Places, compared: Sequence[ComparedSetUp]) -> tuple[str, ...]:
    notes = [words for item in compared if item.name != item.against for words in item.words()]
    off = [item.name for item in compared if item.off]
    if off:
        notes.append(f"Set-ups that are off: {', '.join(off)}. The scatter between set-ups is in the sigmas.")
    unshared = {item.name: item.model.n_modes - modes.shape[1] for item in found}
    notes += [
        f"set-up {name}: {count} of its modes are not in every set-up, and not in the joined model"
        for name, count in unshared.items()
        if count
    ]
    return tuple(notes)
