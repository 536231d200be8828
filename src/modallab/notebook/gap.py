"""Why simulation and bench differ."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from modallab.cli.gap import read_diagnosis
from modallab.core.blas_threads import one_thread
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis, FoundEffect
from modallab.core.digits import probability_text
from modallab.core.effects import kind_of
from modallab.core.errors import DataError, FormatError
from modallab.core.hold_out import HoldOut
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis
from modallab.gap.diagnosis import diagnose as diagnose_campaign
from modallab.gap.inference.agreement import Agreement
from modallab.gap.inference.agreement import agreement as compare_with_simulation
from modallab.gap.report.calibrated import diagnosed_twin
from modallab.gap.words.effects import numbers_of, parameter_in_words, place_of, place_of_change
from modallab.gap.words.verdicts import sentence_by_model, verdict_sentence
from modallab.notebook.arguments import band_of, path_for
from modallab.notebook.display import DisplayedTable
from modallab.notebook.identify import campaign_in
from modallab.notebook.measured_frf import MeasuredFrf
from modallab.notebook.model import Model
from modallab.notebook.recording import Recording
from modallab.notebook.twin import DiagnosedTwin
from modallab.pipelines.structure_gap import Band, gap_against, gap_of, model_to_compare
from modallab.reporting.structure_report import StructureGap, write_structure_report
from modallab.reporting.waiting_line import waiting_line

Reference = Model | Recording | MeasuredFrf | Path | str
"""What a structure is compared with: its modal model, the earlier measurement, or a finite-element model's file."""


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class GapDiagnosis:
    """Result of a diagnosis.

    Attributes:
        campaign: the diagnosed recordings.
        diagnosis: the diagnosis as a document.
        structure: comparison with a reference; None for the rig's own beam.
    """

    campaign: Campaign
    diagnosis: Diagnosis | ModalDiagnosis
    structure: StructureGap | None = None

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        if isinstance(self.diagnosis, ModalDiagnosis):
            return sentence_by_model(self.diagnosis)
        return verdict_sentence(self.diagnosis, [c.name for c in self.campaign.rig.channels])

    @property
    def effects(self) -> list[FoundEffect] | list[FoundChange]:
        """The effects judged present, the most probable first."""
        return self.diagnosis.effects

    @property
    def twin(self) -> DiagnosedTwin:
        """The simulation including these effects.

        Raises:
            DataError: the comparison was with a reference, which no beam of the rig file simulates.
        """
        if isinstance(self.diagnosis, ModalDiagnosis):
            raise DataError(
                "a comparison with a reference has no simulated beam",
                remedy="use `ml.identify(...).modify(...)`, or leave the reference out",
            )
        return DiagnosedTwin(diagnosed_twin(self.diagnosis, self.campaign.rig), self.campaign.rig)

    def table(self) -> DisplayedTable:
        """The effects, a row for each of their numbers, with its 95 % interval, and notes."""
        rows: list[tuple[str, str, str, str, str]] = []
        for effect, place, numbers, likely in self._found():
            rows += [(effect, place, f"{name} = {value}", within, likely) for name, value, within in numbers]
        said = " ".join([self.sentence, *self.diagnosis.notes])
        return DisplayedTable(("effect", "place", "number", "95 %", "probability"), rows, said)

    def _found(self) -> Iterator[tuple[str, str, list[tuple[str, str, str]], str]]:
        """Name, place, numbers and probability of each effect."""
        names = [c.name for c in self.campaign.rig.channels]
        for found in self.effects:
            likely = probability_text(found.probability)
            if isinstance(found, FoundChange):
                yield found.effect, place_of_change(found), numbers_of(found), likely
            else:
                numbers = [(p.name, *parameter_in_words(found, p)) for p in kind_of(found.effect).parameters]
                yield found.effect, place_of(found, names)[0], numbers, likely

    def save(self, path: str | Path) -> Path:
        """Write the diagnosis as JSON, or the report if the name ends with .html; returns the path.

        Raises:
            StorageError: the file cannot be written, or its name has another ending.
        """
        path = path_for(path, (".json", ".html"))
        from modallab.formats.atomic import write_text
        from modallab.reporting.gap_report import write_gap_report

        if path.suffix == ".json":
            write_text(path, self.diagnosis.model_dump_json(indent=1) + "\n")
        elif self.structure is not None:
            write_structure_report(path, self.structure)
        elif isinstance(self.diagnosis, Diagnosis):
            write_gap_report(path, self.diagnosis, self.campaign)
        return path

    def __repr__(self) -> str:
        return f"<GapDiagnosis: {self.sentence}>"

    def _repr_html_(self) -> str:
        return self.table().html()


def diagnose(
    measured: Recording | MeasuredFrf,
    hold_out: str = "mixed",
    *,
    reference: Reference | None = None,
    band: tuple[float, float] | None = None,
    keep: str | Path | None = None,
    progress: bool = True,
) -> GapDiagnosis:
    """Diagnose where simulation and bench differ, the effect that causes it, and the shrinkage of the gap.

    Args:
        measured: result of `simulate`, `load` or `frf`.
        hold_out: records held out from every fit: mixed, spread, point:N, level:NAME, test:impact, test:sine or
            last:SHARE.
        reference: model to compare with, for any structure: its modal model, an earlier measurement, or the file of
            a finite-element model. None: the beam of the rig file.
        band: (low, high) in Hz for the identification of both sides, with a reference; None for the whole band.
        keep: JSON file of the diagnosis; an existing file is read instead of a new diagnosis.
        progress: show the progress, in a notebook or terminal.

    Raises:
        DataError: there are no records, or measured and reference share no band, output or driven point.
        RigError: the rig describes no beam, which the simulation needs.
        PlanError: the rule leaves no records to fit.
        FormatError: the file is no diagnosis of these records, or the reference has an unknown format.
        IdentificationError: measured or reference has no mode.
    """
    campaign = campaign_in(measured)
    if reference is not None:
        if hold_out != "mixed" or keep is not None:
            raise DataError(
                "a comparison with a reference has no held-out records and no file",
                remedy="leave `hold_out` and `keep` out; `.save(path)` writes the result",
            )
        return _compare_reference(campaign, reference, band_of(band), progress)
    if band is not None:
        raise DataError("a band has no effect without a reference", remedy="give `reference`, or leave `band` out")
    if keep is not None and path_for(keep, (".json",)).exists():
        return GapDiagnosis(campaign, _keep_diagnosis(Path(keep), campaign))
    with waiting_line("reading the records", progress=progress):
        found = GapDiagnosis(campaign, diagnose_campaign(campaign, HoldOut.parse(hold_out)))
    if keep is not None:
        found.save(keep)
    return found


@one_thread()
def _compare_reference(campaign: Campaign, reference: Reference, band_hz: Band, progress: bool) -> GapDiagnosis:
    with waiting_line("identifying", progress=progress):
        gap = _campaign_against(campaign, reference, band_hz)
    return GapDiagnosis(campaign, gap.diagnosis, gap)


def agreement(measured: Recording) -> Agreement:
    """Compare the simulation with records, by channel and mode: within seconds, from one hit on.

    Args:
        measured: result of `simulate` or `load`; one hit is enough.

    Raises:
        DataError: the records show no natural frequency and contain no sine test.
        RigError: the rig describes no beam, which the simulation needs.
    """
    return compare_with_simulation(campaign_in(measured))


def _campaign_against(campaign: Campaign, reference: Reference, band_hz: Band) -> StructureGap:
    if isinstance(reference, str | Path):
        return gap_against(campaign, Path(reference), band_hz)
    if isinstance(reference, Model):
        return gap_of(campaign, reference.modal_model, band_hz=band_hz)
    before = campaign_in(reference)
    return gap_of(campaign, model_to_compare(before, band_hz), "the earlier measurement", before, band_hz)


def _keep_diagnosis(path: Path, campaign: Campaign) -> Diagnosis:
    diagnosis = read_diagnosis(path)
    # The hits at a point are one record of a diagnosis, named as they begin.
    names = tuple(b.name for b in campaign.blocks)
    known = all(any(name.startswith(record) for name in names) for record in diagnosis.gap.by_record)
    if diagnosis.rig != campaign.rig.name or not known:
        raise FormatError(
            f"is a diagnosis of different records, on {diagnosis.rig}",
            where=str(path),
            remedy="name another file, or delete this file to diagnose again",
        )
    return diagnosis
