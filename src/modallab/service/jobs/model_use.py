"""The newest model of a campaign put to use. What it needs takes seconds to import, so it is imported when used."""

from typing import TYPE_CHECKING

import numpy as np

from modallab.core.documents.model_change import (
    AbsorberNew,
    ChangeNew,
    CheckedMode,
    CouplingNew,
    ElementNew,
    MobilityView,
    ModificationNew,
    ModifiedView,
    PairNew,
)
from modallab.core.documents.model_use import (
    ResponseNew,
    ResponseView,
    StartNew,
    StateSpaceView,
)
from modallab.core.documents.models import TestModel
from modallab.core.errors import DataError
from modallab.core.units import Quantity, Test
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.results import models_of_campaign

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from modallab.modification.attachments import AttachedPart
    from modallab.modification.known import KnownStructure
    from modallab.modification.structure import At

KEPT = 8
"""Models that stay ready for use: their samples take longer than what is asked of them."""
_READY: dict[tuple[str, Test | None, tuple[str, ...]], "KnownStructure"] = {}
MOST_SAMPLES = 100_000
"""Of a force by kind: more are computed beside the service, from its model."""


def modified_modes_view(service: Service, campaign: str, new: ModificationNew) -> ModifiedView:
    """The modes after changes.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a change that is none, a point that the model does not know, or no driving point.
    """
    from modallab.modification.skeleton import motion_of
    from modallab.reporting.modified_table import check_predictions, notes_of

    known = known_of_campaign(service, campaign, new.test)
    changes = [_addition(service, change) for change in new.changes]
    changed = known.with_changes(changes)
    after = changed.modes
    measured = None if new.check is None else model_of_campaign(service, new.check, new.test).model
    return ModifiedView(
        test=known.model.test,
        changes=tuple(change.words for change in changes),
        frequency_hz=after.frequency_hz,
        frequency_sigma_hz=after.frequency_sigma_hz,
        damping_ratio=after.damping_ratio,
        damping_sigma=after.damping_sigma,
        like=tuple(int(n) + 1 for n in after.like),
        mac=after.mac,
        outside=after.outside,
        conditioning=changed.conditioning,
        notes=tuple(notes_of(changed)),
        before_hz=known.model.frequency_hz,
        frf=None if new.frf is None else _mobility(known, changed, new.frf),
        checked=()
        if measured is None
        else tuple(
            CheckedMode(
                mode=c.mode,
                predicted_hz=c.predicted_hz,
                predicted_sigma_hz=c.sigma_hz,
                measured_hz=c.measured_hz,
                inside=c.inside,
                words=c.words,
            )
            for c in check_predictions(after, measured)
        ),
        motion=None if known.rig is None else motion_of(known.structure, known.rig, after.psi),
    )


def _mobility(known: "KnownStructure", changed: "KnownStructure", pair: PairNew) -> MobilityView:
    from modallab.modification.frfs import lines_with_peaks

    f = lines_with_peaks(known.model.band_hz, pair.lines, known.structure.poles, changed.poles)
    before, after = (one.frf(f, [pair.of], [pair.at], sigma=False).values[0, 0] for one in (known, changed))
    return MobilityView(frequency_hz=f, before=before, after=after)


def _addition(service: Service, new: ChangeNew) -> "AttachedPart":
    from modallab.modification.attachments import Element, RigidLink, TunedAbsorber
    from modallab.modification.coupled import CouplingToStructure

    if isinstance(new, ElementNew):
        return Element(new.at, new.to, new.mass_kg, new.spring_n_per_m, new.damper_n_s_per_m)
    if isinstance(new, AbsorberNew):
        return TunedAbsorber(new.at, new.mass_kg, new.frequency_hz, new.damping_ratio)
    if isinstance(new, CouplingNew):
        other = known_of_campaign(service, new.campaign, None)
        sign = -1 if new.remove else 1
        return CouplingToStructure(other.structure, new.pairs, new.joint_n_per_m, sign, samples=other.samples)
    return RigidLink(new.at, new.to)


def response_to(service: Service, campaign: str, new: ResponseNew) -> ResponseView:
    """The motion that forces give.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: forces that cannot be, a point that the model does not know, or no driving point.
    """
    from modallab.modification.motion import MotionOverTime

    known = known_of_campaign(service, campaign, new.test)
    start = _start_of_motion(new.start or ())
    found = MotionOverTime.of(known, _forces(new), new.step_s, new.at, new.of, new.quantity, new.between, start)
    figures, sigma = found.figures, found.figures_sigma
    return ResponseView(
        test=known.model.test,
        quantity=new.quantity,
        step_s=new.step_s,
        of=tuple(p[0] if isinstance(p, tuple) else p for p in found.points),
        values=found.values if new.samples else None,
        sigma=found.sigma if new.samples else None,
        peak=figures[:, 0],
        peak_sigma=sigma[:, 0],
        rms=figures[:, 1],
        rms_sigma=sigma[:, 1],
        octaves_hz=np.array(found.octaves_hz),
        levels=figures[:, 2:],
        levels_sigma=sigma[:, 2:],
        outside=found.outside,
    )


def _forces(new: ResponseNew) -> "NDArray[np.float64]":
    """(forces, samples) N."""
    from modallab.modification.forces import force_samples

    if (new.forces_n is None) == (new.forces is None):
        raise DataError("forces are given twice, or not at all", where="forces", remedy="give forces_n or forces")
    if new.forces_n is not None:
        if len({len(force) for force in new.forces_n}) > 1:
            raise DataError("forces of several lengths", where="forces_n", remedy="give rows of one length")
        return np.array(new.forces_n)
    count = 0 if new.seconds is None else round(new.seconds / new.step_s)
    if not 2 <= count <= MOST_SAMPLES:
        raise DataError(f"{count} samples", where="seconds", remedy=f"give seconds for 2 to {MOST_SAMPLES} samples")
    return np.array([force_samples(force, new.step_s, count) for force in new.forces or ()])


def _start_of_motion(given: tuple[StartNew, ...]) -> "dict[Quantity, dict[At, float]] | None":
    whole: dict[Quantity, dict[At, float]] = {
        "displacement": {one.at: one.displacement_m for one in given if one.displacement_m is not None},
        "velocity": {one.at: one.velocity_m_s for one in given if one.velocity_m_s is not None},
    }
    return {name: values for name, values in whole.items() if values} or None


def state_space_of_model(
    service: Service, campaign: str, test: Test | None, at: list[int], of: list[int] | None, quantity: Quantity
) -> StateSpaceView:
    """Matrices from forces to motions.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a point that the model does not know, or no driving point.
    """
    known = known_of_campaign(service, campaign, test)
    found = known.state_space(at, of or known.sensors, quantity)
    return StateSpaceView.model_validate({"test": known.model.test, **found.document()})


def known_of_campaign(service: Service, campaign: str, test: Test | None) -> "KnownStructure":
    """The newest model of a test, ready for use; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no driving point, or a point that is not known.
    """
    from modallab.modification.known import KnownStructure

    found = model_of_campaign(service, campaign, test)
    key = (found.job, found.model.test, found.runs)
    if key in _READY:
        return _READY[key]
    known = KnownStructure(found.model, service.store.catalogue.run(found.runs[0]).rig)
    while len(_READY) >= KEPT:
        _READY.pop(next(iter(_READY)))
    return _READY.setdefault(key, known)


def model_of_campaign(service: Service, campaign: str, test: Test | None) -> TestModel:
    """The newest model of a test; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
    """
    there = models_of_campaign(service, campaign).models
    for one in there:
        if test in (None, one.model.test):
            return one
    raise NotFoundError(
        f"campaign {campaign} has no model of {'any' if test is None else 'the ' + test} test",
        where="test",
        remedy=f"there are: {', '.join(str(one.model.test) for one in there) or 'none'}",
    )
