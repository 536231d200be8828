"""The forms in which the corrected twin goes to other programs, and each one's own gap to the bench, before and after.

What is measured is what was written: the file is read back and plays the records.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import DataError
from modallab.core.frozen import Frozen
from modallab.core.progress import report_progress
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.gap.conditioning.records import records_in_volts, usable_records
from modallab.gap.design.prediction import Records, predict_records
from modallab.gap.export.mjcf import mujoco_simulation, write_mjcf
from modallab.gap.export.modal_file import read_modal, write_modal
from modallab.gap.export.state_space import read_state_space, state_space, write_state_space
from modallab.gap.report.calibrated import diagnosed_twin, twin_of_rig_file
from modallab.gap.report.measure import BARE, share_of_gap_closed
from modallab.gap.simulations.simulated_records import Simulate, simulated_records, simulation_residual
from modallab.twin.bench import Twin

Simulations = Mapping[Test, Simulate]


@dataclass(frozen=True, slots=True)
class MeasuredForm:
    """One form.

    Attributes:
        name: in commands.
        says: what it is, in a few words.
        suffix: of its files.
        tests: how many tests a file holds.
        write: (file, twin, rig, tests, rate in Hz or None).
        read: (file, rig, tests) -> what simulates each test.
    """

    name: str
    says: str
    suffix: str
    write: Callable[[Path, Twin, Rig, Sequence[Test], float | None], None]
    read: Callable[[Path, Rig, Sequence[Test]], Simulations]
    one_test: bool = False


class FormError(Frozen):
    """How far the twin in a form is from the bench.

    Attributes:
        form: its name.
        before: gap in noise units of the twin as the rig file has it, in this form; nothing is fitted.
        after: the same of the twin as diagnosed.
        closed: share of the reducible gap that is closed; None where there was next to none.
        twin_after: gap of the diagnosed twin itself on the same records.
        records: on which it was measured.
    """

    form: str
    before: float
    after: float
    closed: float | None
    twin_after: float
    records: list[str]


def tests_of(rig: Rig) -> list[Test]:
    """The tests that a rig knows: hits, and sines where it has a shaker."""
    return ["impact", *(["sine"] if rig.shaker_point is not None else [])]


def write_form(
    path: Path, form: MeasuredForm, diagnosis: Diagnosis, rig: Rig, tests: Sequence[Test], rate_hz: float | None
) -> None:
    """Write the twin of a diagnosis in a form.

    Raises:
        DataError: the form has no place for the twin, or for more than one test.
        MissingPackageError: a library that it needs is not installed.
        StorageError: the file cannot be written.
    """
    if form.one_test and len(tests) > 1:
        raise DataError(f"a file of {form.name} holds one test", remedy="name the test, impact or sine")
    form.write(path, diagnosed_twin(diagnosis, rig), rig, tests, rate_hz)


def measure_form(
    form: MeasuredForm, diagnosis: Diagnosis, campaign: Campaign, tests: Sequence[Test], most: int | None
) -> FormError:
    """Measure a form on records of a campaign: those its diagnosis held out, where it is of this campaign.

    Args:
        form: which.
        diagnosis: the twin.
        campaign: the bench's records.
        tests: records of these tests count.
        most: at most so many records, spread over all; None for all.

    Raises:
        DataError: no record of these tests says what drove it; or as `write_form`.
    """
    names = _record_names(campaign, diagnosis, tests, most)
    rig = campaign.rig
    gaps: list[float] = []
    for step, twin in enumerate((twin_of_rig_file(rig), diagnosed_twin(diagnosis, rig))):
        report_progress(step / 2, f"{form.name}, {'after' if step else 'before'}")
        gaps.append(simulation_residual(campaign, _simulate_form(form, twin, campaign, names)).gap)
    used = {name for of_test in names.values() for name in of_test}
    own = {name: values for name, values in predict_records(diagnosis, campaign).items() if name in used}
    before, after = gaps
    return FormError(
        form=form.name,
        before=before,
        after=after,
        closed=share_of_gap_closed(before, after) if before**2 - 1 > BARE else None,
        twin_after=simulation_residual(campaign, own).gap,
        records=sorted(used),
    )


def _simulate_form(form: MeasuredForm, twin: Twin, campaign: Campaign, names: Mapping[Test, list[str]]) -> Records:
    """Records of the twin in a form, by the file that it is written to."""
    rig, tests = campaign.rig, list(names)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"twin{form.suffix}"
        form.write(path, twin, rig, tests, None)
        simulations = form.read(path, rig, tests)
        return {
            name: values
            for test in tests
            for name, values in simulated_records(simulations[test], campaign, names[test], FINER).items()
        }


FINER = 16
"""Steps per sample: MuJoCo's must be short enough for the fastest mode, whatever the rate of the records."""


def _record_names(
    campaign: Campaign, diagnosis: Diagnosis, tests: Sequence[Test], most: int | None
) -> dict[Test, list[str]]:
    blocks = [b for b in usable_records(records_in_volts(campaign)) if b.test in tests]
    held = set(diagnosis.shrink.held_out)
    chosen = [b for b in blocks if b.name in held] or blocks
    if not chosen:
        raise DataError(
            f"no record of {' or '.join(tests)} has a drive point", where=campaign.source, remedy="name another test"
        )
    if most is not None and len(chosen) > most:
        chosen = [chosen[k] for k in np.linspace(0, len(chosen) - 1, most).round().astype(int)]
    return {test: [b.name for b in chosen if b.test == test] for test in tests}


def _write_systems(path: Path, twin: Twin, rig: Rig, tests: Sequence[Test], rate_hz: float | None) -> None:
    write_state_space(path, {test: state_space(twin, rig, test) for test in tests}, rig, rate_hz)


def _read_systems(path: Path, rig: Rig, tests: Sequence[Test]) -> Simulations:
    found = read_state_space(path)
    return {test: found[test].simulate for test in tests}


def _read_modes(path: Path, rig: Rig, tests: Sequence[Test]) -> Simulations:
    found = read_modal(path, rig)
    return {test: found[test].simulate for test in tests}


FORMS = {
    form.name: form
    for form in (
        MeasuredForm("npz", "state space for NumPy", ".npz", _write_systems, _read_systems),
        MeasuredForm("mat", "state space for MATLAB", ".mat", _write_systems, _read_systems),
        MeasuredForm(
            "mjcf",
            "chain of links for MuJoCo",
            ".xml",
            lambda path, twin, rig, tests, _: write_mjcf(path, twin, rig, tests[0]),
            lambda path, rig, tests: {tests[0]: mujoco_simulation(path, rig)},
            one_test=True,
        ),
        MeasuredForm(
            "uff",
            "modes and FRFs as a universal file, of the structure alone",
            ".uff",
            lambda path, twin, rig, tests, _: write_modal(path, twin, rig, tests),
            _read_modes,
        ),
    )
}
"""Name -> form."""
