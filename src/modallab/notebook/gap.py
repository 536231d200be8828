"""Why simulation and bench differ."""

from dataclasses import dataclass
from pathlib import Path

from modallab.cli.gap import read_diagnosis
from modallab.core.blas_threads import one_thread
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis, Found
from modallab.core.digits import probability
from modallab.core.effects import kind_of
from modallab.core.errors import FormatError
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.gap.diagnosis import diagnose as diagnose_campaign
from modallab.gap.inference.agreement import Agreement
from modallab.gap.inference.agreement import agreement as compare_with_simulation
from modallab.gap.report.calibrated import diagnosed_twin
from modallab.gap.words.effects import of_parameter, place_of
from modallab.gap.words.verdicts import sentence
from modallab.notebook.arguments import path_for
from modallab.notebook.identify import campaign_in
from modallab.notebook.measured import MeasuredFrf
from modallab.notebook.model import Model
from modallab.notebook.recording import Recording
from modallab.notebook.shown import Shown
from modallab.notebook.twin import DiagnosedTwin
from modallab.pipelines.structure_gap import gap_against, gap_of, model_to_compare
from modallab.reporting.structure_report import StructureGap, write_structure_report
from modallab.reporting.waiting import waiting


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class GapFound:
    """What a diagnosis found.

    Attributes:
        campaign: the recordings it looked at.
        diagnosis: everything it says, as a document.
    """

    campaign: Campaign
    diagnosis: Diagnosis

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        return sentence(self.diagnosis, [c.name for c in self.campaign.rig.channels])

    @property
    def effects(self) -> list[Found]:
        """The effects judged present, the most probable first."""
        return list(self.diagnosis.effects)

    @property
    def twin(self) -> DiagnosedTwin:
        """The simulation with these effects in it."""
        return DiagnosedTwin(diagnosed_twin(self.diagnosis, self.campaign.rig), self.campaign.rig)

    def table(self) -> Shown:
        """The effects, a row for each of their numbers, with the interval of 95 %."""
        rows: list[tuple[str, str, str, str, str]] = []
        names = [c.name for c in self.campaign.rig.channels]
        for found in self.diagnosis.effects:
            place = place_of(found, names)[0]
            for number in kind_of(found.effect).parameters:
                value, between = of_parameter(found, number)
                rows.append((found.effect, place, f"{number.name} = {value}", between, probability(found.probability)))
        return Shown(("effect", "place", "number", "95 %", "probability"), rows, self.sentence)

    def save(self, path: str | Path) -> Path:
        """Write the diagnosis as JSON, or the report if the name ends with .html; returns the path.

        Raises:
            StorageError: the file cannot be written, or its name ends otherwise.
        """
        path = path_for(path, (".json", ".html"))
        from modallab.formats.atomic import write_text
        from modallab.reporting.gap_report import write_gap_report

        if path.suffix == ".html":
            write_gap_report(path, self.diagnosis, self.campaign)
            return path
        write_text(path, self.diagnosis.model_dump_json(indent=1) + "\n")
        return path

    def __repr__(self) -> str:
        return f"<GapFound: {self.sentence}>"

    def _repr_html_(self) -> str:
        return self.table().html()


def diagnose(
    measured: Recording, hold_out: str = "mixed", *, keep: str | Path | None = None, progress: bool = True
) -> GapFound:
    """Where simulation and bench differ, which effect causes it, and how far the gap shrinks with it.

    Args:
        measured: what `simulate` or `load` gave.
        hold_out: records no fit may see: mixed, spread, point:N, level:NAME, test:impact, test:sine or last:SHARE.
        keep: where to keep the diagnosis as JSON; if the file is there, it is read, which takes no time.
        progress: show how far it is, where somebody looks.

    Raises:
        DataError: there is nothing to diagnose.
        RigError: the rig describes no beam, which the simulation needs.
        PlanError: the rule leaves nothing to fit.
        FormatError: what is kept there is no diagnosis of these records.
    """
    campaign = campaign_in(measured)
    if keep is not None and path_for(keep, (".json",)).exists():
        return GapFound(campaign, _kept(Path(keep), campaign))
    with waiting("reading the records", progress=progress):
        found = GapFound(campaign, diagnose_campaign(campaign, str(hold_out)))
    if keep is not None:
        found.save(keep)
    return found


def agreement(measured: Recording) -> Agreement:
    """Whether the simulation agrees with records, and which channels or modes do not: within seconds, from one hit on.

    Args:
        measured: what `simulate` or `load` gave; one hit is enough.

    Raises:
        DataError: the records show no natural frequency and contain no sine test.
        RigError: the rig describes no beam, which the simulation needs.
    """
    return compare_with_simulation(campaign_in(measured))


@one_thread()
def diagnose_by_model(
    measured: Recording | MeasuredFrf,
    reference: Model | Recording | MeasuredFrf | Path | str,
    *,
    report: str | Path | None = None,
    progress: bool = True,
) -> ModalDiagnosis:
    """Where a structure differs from its modal model, whatever structure it is, beyond the rig's tolerances.

    Args:
        measured: of the structure as it is.
        reference: its modal model, or what was measured before, with the same channels and driven points; or a file
            of a finite-element model.
        report: where to write the HTML page of it.
        progress: show how far it is, where somebody looks.

    Raises:
        DataError: the two share no band, output or driven point.
        FormatError: the file can be read as none of these.
        IdentificationError: one of them holds no mode.
        StorageError: the page cannot be written, or its name does not end with .html.
    """
    campaign = campaign_in(measured)
    page = None if report is None else path_for(report, (".html",))
    with waiting("identifying", progress=progress):
        gap = _against(campaign, reference)
    if page is not None:
        write_structure_report(page, gap)
    return gap.diagnosis


def _against(campaign: Campaign, reference: Model | Recording | MeasuredFrf | Path | str) -> StructureGap:
    if isinstance(reference, str | Path):
        return gap_against(campaign, Path(reference))
    if isinstance(reference, Model):
        return gap_of(campaign, reference.modal)
    before = campaign_in(reference)
    return gap_of(campaign, model_to_compare(before), "what was measured before", before)


def _kept(path: Path, campaign: Campaign) -> Diagnosis:
    diagnosis = read_diagnosis(path)
    # The hits at a point are one record of a diagnosis, named as they begin.
    names = tuple(b.name for b in campaign.blocks)
    known = all(any(name.startswith(record) for name in names) for record in diagnosis.gap.by_record)
    if diagnosis.rig != campaign.rig.name or not known:
        raise FormatError(
            f"is a diagnosis of other records, on {diagnosis.rig}",
            where=str(path),
            remedy="name another file, or delete this one to diagnose again",
        )
    return diagnosis
