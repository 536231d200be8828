"""From records of any structure, and its modal model from before, to what has changed."""

from dataclasses import dataclass, replace
from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.errors import DataError, RigError
from modallab.core.frf import Frf
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.fem.fem_file import FemModel, is_fem, read_fem
from modallab.frf.estimate import group_by_point
from modallab.gap.modal.diagnosis import ComparisonOutcome, explained_by_model
from modallab.gap.modal.halves import share_between_halves
from modallab.identification.impact import start_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.mesh import Mesh
from modallab.pipelines.identify import CampaignResult, IdentifiedTest, usable_blocks
from modallab.pipelines.model_file import read_models
from modallab.pipelines.response_only import identify_chosen
from modallab.reporting.structure_report import StructureGap
from modallab.signals.signals import Signals
from modallab.updating.elements import frf_of_elements, mesh_shapes, model_of_elements

Band = tuple[float, float] | None
"""From and to, Hz."""


@dataclass(frozen=True, eq=False, slots=True)
class ComparedWith:
    """What a structure is compared with.

    Attributes:
        model: at the rig's points and channels.
        named: it in words.
        mesh: its shapes at nodes between the points, where it was computed.
        before: the campaign that it was identified from, if it was.
        elements: the finite elements that it was computed with, if it was.
    """

    model: ModalModel
    named: str
    mesh: Mesh | None = None
    before: Campaign | None = None
    elements: FemModel | None = None

    def frf(self, rig: Rig, like: Frf | None) -> Frf | None:
        """Its FRFs, where they are known: measured, or computed on the lines of those of the bench."""
        if self.elements is None:
            return _frf_of(self.before, self.model)
        return None if like is None else frf_of_elements(self.elements, rig, like, _driven_points(self.model))


def gap_of(
    campaign: Campaign,
    reference: ModalModel,
    named: str = "a modal model",
    before: Campaign | None = None,
    band_hz: Band = None,
) -> StructureGap:
    """What differs between a modal model and the structure of a campaign, beyond the tolerances of its rig.

    Args:
        campaign: of the structure as it is.
        reference: the modal model.
        named: it in words.
        before: the campaign that it was identified from, if it was.
        band_hz: in which the campaign is identified; None for the whole band.

    Returns:
        the diagnosis, with all that its report shows.

    Raises:
        DataError: the two have nothing in common.
        IdentificationError: the campaign holds no mode.
    """
    return gap_between(campaign, ComparedWith(reference, named, before=before), _identify_bench(campaign, band_hz))


def gap_against(campaign: Campaign, path: Path, band_hz: Band = None) -> StructureGap:
    """The same against the reference in a file: models, an earlier campaign, or a finite-element model.

    Args:
        campaign: of the structure as it is.
        path: of the reference.
        band_hz: in which campaigns are identified; None for the whole band.

    Returns:
        the diagnosis, with all that its report shows.

    Raises:
        DataError: the two have nothing in common.
        FormatError: the file can be read as none of these.
        IdentificationError: a campaign holds no mode.
    """
    identified = _identify_bench(campaign, band_hz)
    reference = read_reference(path, campaign.rig, identified.identified[0].model, band_hz)
    return gap_between(campaign, reference, identified)


def gap_between(campaign: Campaign, reference: ComparedWith, identified: CampaignResult) -> StructureGap:
    """What differs between a reference and the first model that a campaign gave.

    Args:
        campaign: it was identified from.
        reference: at the rig's points and channels.
        identified: what it gave.

    Raises:
        DataError: the two have nothing in common.
    """
    bench = identified.identified[0]
    own = None if reference.before is None else reference.before.rig
    measured, rig = _frf_of(campaign, bench.model, bench.index), campaign.rig.of_outputs(bench.model.outputs)
    frfs = reference.frf(rig, measured), measured
    explained = explained_by_model(reference.model, bench.model, rig, reference.mesh, own, frfs)
    explained = replace(explained, diagnosis=_with_floor(explained.diagnosis, campaign, bench.model))
    records = None if bench.verification is None else bench.verification.measured
    return StructureGap(rig, explained, reference.named, records, _not_compared(identified, explained, bench))


def _with_floor(found: ModalDiagnosis, campaign: Campaign, model: ModalModel) -> ModalDiagnosis:
    """The diagnosis, first of all with what two measurements of the same thing differ by, where hits say it."""
    if model.test != "impact":
        return found
    floor = share_between_halves(*_hits_of(campaign), model.band_hz)
    if floor is None:
        return found
    note = f"The two halves of the bench's hits differ by {100 * floor:.2g} % of the response."
    return found.model_copy(update={"notes": [note, *found.notes]})


def _hits_of(campaign: Campaign) -> tuple[list[list[Signals]], Rig]:
    signals, rig, _ = usable_blocks(campaign, campaign.of("impact"))
    return group_by_point(signals), rig


def _frf_of(campaign: Campaign | None, model: ModalModel, index: int = 0) -> Frf | None:
    """The FRFs that a model was identified from; None of a drive's, which hold the leakage of their blocks."""
    if campaign is None:
        return None
    if model.test == "impact":
        return start_frf(*_hits_of(campaign), model.band_hz)
    return campaign.frfs[index] if model.test is None and campaign.frfs else None


def _kind_of_file(path: Path) -> str:
    if path.suffix == ".json":
        return "a modal model"
    return "a finite-element model" if is_fem(path) else "an earlier campaign"


def _not_compared(identified: CampaignResult, explained: ComparisonOutcome, bench: IdentifiedTest) -> tuple[str, ...]:
    """What of a campaign was not compared, a sentence each."""
    model, reference = bench.model, explained.free.of.model
    tests = [f.source for f in (*identified.identified[1:], *identified.unidentified)]
    outputs = [name for name in model.outputs if name not in reference.outputs]
    points = [p for p in dict.fromkeys(model.input_points) if p not in reference.input_points]
    note = (
        (tests, f"Other tests of the campaign than {bench.source}: {', '.join(tests)}."),
        (outputs, f"Outputs that the reference does not have: {', '.join(outputs)}."),
        (points, f"Driven points that the reference does not have: {', '.join(map(str, points))}."),
    )
    return tuple(line for there, line in note if there)


def model_to_compare(campaign: Campaign, band_hz: Band = None) -> ModalModel:
    """The campaign's first modal model: of hits where there are any, else of the next test.

    Args:
        campaign: its rig has points.
        band_hz: in which it is identified; None for the whole band.

    Raises:
        DataError: a sensor or a force has no point.
        IdentificationError: there is no mode.
    """
    return _identify_bench(campaign, band_hz).identified[0].model


def _identify_bench(campaign: Campaign, band_hz: Band) -> CampaignResult:
    _require_points(campaign)
    return identify_chosen(campaign, IdentificationOptions(band_hz=band_hz))


def _require_points(campaign: Campaign) -> None:
    """Ask for points before anything is identified.

    Raises:
        DataError: a sensor or a force has none, in the records or on the rig.
    """
    rig = campaign.rig
    without = [f"channel {c.name}" for c in rig.responses if c.point is None]
    given = {b.drive_point for b in campaign.blocks} | {p for frf in campaign.frfs for p in frf.input_points}
    if rig.force is not None and rig.force.point is None and None in given:
        without.append("the force")
    if without:
        raise DataError(
            f"no point is known of {', '.join(without)}",
            where=campaign.source,
            remedy="write the points into a rig file, and give that file with --rig",
        )


def read_reference(path: Path, rig: Rig, bench: ModalModel, band_hz: Band = None) -> ComparedWith:
    """The reference of a file of models, of a finite-element model, or of a campaign, which is identified.

    Args:
        path: of it.
        rig: whose points and channels it is taken at.
        bench: what is compared with it: in its band, and driven where it was, a finite-element model is taken.
        band_hz: in which a campaign is identified; None for the whole band.

    Raises:
        DataError: it holds no model, or none that fits the rig.
        FormatError: it can be read as none of these.
        IdentificationError: the campaign holds no mode.
    """
    named = f"{_kind_of_file(path)}, {path.name}"
    if path.suffix == ".json":
        models = read_models(path)
        if not models:
            raise DataError("holds no model", where=str(path), remedy="write one with modallab identify --json")
        return ComparedWith(models[0], named)
    if is_fem(path):
        fem = read_fem(path)
        how = (fem, rig, bench.band_hz, _driven_points(bench))
        return ComparedWith(model_of_elements(*how), named, mesh_shapes(*how), elements=fem)
    before = _on_its_own_rig(path, rig)
    return ComparedWith(model_to_compare(before, band_hz), named, before=before)


def _driven_points(model: ModalModel) -> tuple[int, ...]:
    return tuple(p for p in dict.fromkeys(model.input_points) if p is not None)


def _on_its_own_rig(path: Path, rig: Rig) -> Campaign:
    """A campaign on the rig it was recorded on; on another where none is in or beside it, or that one has no points."""
    try:
        before = read_campaign(path)
    except RigError:
        return read_campaign(path, rig)
    return before if before.rig.points else read_campaign(path, rig)
