"""What the sensitivities' own uncertainty does to a model's scale: the same relative error in every mode.

A modal constant is a response over a force, so that both sensitivities count; a shape at unit modal mass takes its
scale from the driving point by a root. Sensors are taken as independent of each other.
"""

import numpy as np

from modallab.core.model import ModalModel, ScaleUncertainty
from modallab.core.rig import Channel, Rig
from modallab.core.units import BROADBAND
from modallab.identification.model.modal_mass import driving_points


def relative_sigma(channel: Channel, rig: Rig) -> float | None:
    """One standard deviation of a channel's sensitivity, relative: by its last calibration; None where none states it.

    A certificate and the rig's history both count; the later one is taken.
    """
    history = [e for e in rig.history if e.channel == channel.name and e.sigma_v_per_unit > 0]
    latest = max(history, key=lambda entry: entry.date, default=None)
    certificate = channel.certificate
    if certificate is not None and (latest is None or latest.date <= certificate.date):
        return certificate.relative_sigma
    if latest is None:
        return None
    return latest.sigma_v_per_unit / abs(latest.sensitivity_v_per_unit)


def with_scale(model: ModalModel, rig: Rig) -> ModalModel:
    """The model with the uncertainty of its scale, as far as certificates or calibrations state it."""
    force = _force_sigma(model, rig)
    known = {channel.name: relative_sigma(channel, rig) for channel in rig.responses}
    if force is None and not any(known.get(name) for name in model.outputs):
        return model
    f = np.nan if force is None else force
    u = np.array([np.nan if (value := known.get(name)) is None else value for name in model.outputs])
    constants = np.hypot(u, f)
    row = _driving_row(model, rig)
    if row is None:
        shapes, mass = np.full(len(u), np.nan), None
    else:
        shapes = np.sqrt(u**2 + (u[row] ** 2 + f**2) / 4)
        mass = float(constants[row]) if np.isfinite(constants[row]) else None
        shapes[row] = constants[row] / 2
    scale = ScaleUncertainty(force=force, responses=u, modal_constants=constants, shapes=shapes, modal_mass=mass)
    return model.model_copy(update={"scale_uncertainty": scale})


def _force_sigma(model: ModalModel, rig: Rig) -> float | None:
    """Of the force; of several that drove at once the least certain one's, None where one of them states none."""
    used = rig.forces if model.test in BROADBAND and len(model.input_points) > 1 else (rig.force_channel,)
    sigmas = [relative_sigma(channel, rig) for channel in used]
    known = [sigma for sigma in sigmas if sigma is not None]
    return max(known) if len(known) == len(sigmas) else None


def _driving_row(model: ModalModel, rig: Rig) -> int | None:
    along = dict(zip((c.name for c in rig.responses), driving_points(rig), strict=True))
    driven = [p for p in model.input_points if p is not None]
    rows = (n for p in driven for n, name in enumerate(model.outputs) if along.get(name) == p)
    return next(rows, None)
