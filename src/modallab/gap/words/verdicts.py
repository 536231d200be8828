"""A verdict in one sentence: of a campaign, of a measured structure, of another program's simulation."""

from collections.abc import Sequence

from modallab.core.diagnosis import Diagnosis, Found, Gap, Percent
from modallab.core.digits import listed, part_of, percent, probability, rounded
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.gap.simulations.compare import Compared
from modallab.gap.words.effects import spoken, with_numbers

KNOWN = 2.0
"""Factor from before to after that is no matter of tolerances."""
NEXT_TO_NOTHING = 1e-6
ORDINARY = "(rms; 1 is ordinary)"


def sentence(diagnosis: Diagnosis, channels: Sequence[str] = ()) -> str:
    """The verdict on a campaign.

    Args:
        diagnosis: of a campaign.
        channels: names of its rig's channels, where they are known.
    """
    gap = diagnosis.gap
    if diagnosis.verdict == "no_gap":
        within = "tolerances" if diagnosis.twin.departures else "noise"
        # What no force predicts, and the rig's revisions know, no twin takes away; it is no gap any more.
        known = gap.before > KNOWN * gap.after
        left = f"{gap.after:.2f} noise units with what its revisions know" if known else f"{gap.before:.2f} noise units"
        return f"Twin and bench agree to within the {within}: the gap is {left}, the floor 1."
    if diagnosis.verdict == "unknown":
        where = diagnosis.where
        at = f" on {', '.join(where.channels)}" if 0 < len(where.channels) < 4 else ""
        return (
            f"A gap of {rounded(gap.before)} noise units lies in the {where.stage}{at}, and none of the known effects "
            f"explains it.{_behaves(diagnosis)}"
        )
    parts = " and ".join(spoken(f, channels) for f in diagnosis.effects)
    return f"The gap of {rounded(gap.before)} noise units comes from {parts}{_closes(diagnosis.shrink.closed)}."


def _closes(share: float | None) -> str:
    return "" if share is None else f", which closes {part_of(share)} of it on records held out"


def _behaves(diagnosis: Diagnosis) -> str:
    """What a gap without a name behaves like, and how far that closes it."""
    described = diagnosis.described
    if described is None or described.shrink.closed is None:
        return ""
    return f" It behaves like {described.says.rstrip(',')}{_closes(described.shrink.closed)}."


def in_percent(gap: Gap) -> str:
    """The gap as a share of the response, in one sentence; "" where it is not known."""
    stages = (
        ("as the rig file describes the bench", gap.share_nominal),
        ("within the tolerances", gap.share_before),
        ("with what was found", gap.share_after),
    )
    parts = [f"{_sides(share)} {name}" for name, share in stages if share is not None and _sides(share)]
    whole = f"In percent of the response, at resonance and away from it: {'; '.join(parts)}." if parts else ""
    return " ".join(s for s in (whole, own_error(gap)) if s)


def _sides(share: Percent) -> str:
    return listed([of_response(v) for v in (share.at_resonance, share.away) if v is not None])


def of_response(share: float | None) -> str:
    """A share of the response with its noise taken off, which is never known to be nothing."""
    return percent(None if share is None else max(share, NEXT_TO_NOTHING))


def own_error(gap: Gap) -> str:
    """What is left of the records beyond noise, in one sentence; "" where it is not known."""
    left = gap.discrepancy
    if left is None:
        return ""
    if not left.worst:
        return "Beyond noise nothing is left of any record."
    return (
        f"Beyond noise, {of_response(left.median)} of a record is left unexplained (median); "
        f"at worst {of_response(left.worst)}, of {left.record}."
    )


def sentence_by_model(found: ModalDiagnosis) -> str:
    """The verdict on a structure that was compared with its modal model, with its probability."""
    before = f"{percent(found.before)} of the response differs"
    differs = f"{before}, by {found.strain_before:.2g} deviations of the tolerances"
    if found.verdict == "no_gap":
        return f"No gap beyond the tolerances{_probable(found.nothing)}: {differs} {ORDINARY}."
    if found.verdict == "unknown":
        return f"A gap that no effect of the catalogue explains{_probable(found.unknown)}: {differs} {ORDINARY}."
    parts = " and ".join(with_numbers(change) for change in found.effects)
    left = f"{percent(found.after)}, by {found.strain_after:.2g}"
    return f"{parts[0].upper()}{parts[1:]}. Without it {differs} {ORDINARY}; with it {left}."


def _probable(value: float | None) -> str:
    """Files of earlier versions state none."""
    return "" if value is None else f", probability {probability(value)}"


def sentence_of_simulation(found: Compared) -> str:
    """The verdict on a simulation that was compared with the bench."""
    before, after = rounded(found.before), rounded(found.after)
    if found.verdict == "no_gap":
        agree = f"No effect distinguishes simulation and bench: the gap is {before} noise units"
        return f"{agree}, {after} with the beam's numbers as the bench has them."
    off = f"The simulation is {before} noise units off the bench"
    if found.verdict == "unknown":
        return f"{off}, and not all of that is explained."
    share = "" if found.closed is None else f"that closes {part_of(found.closed)} of it, "
    return f"{off}: {'; '.join(_differences(found))}. Corrected, it is {after} off; {share}on {_records(found)}."


def _records(found: Compared) -> str:
    return f"{len(found.records)} records held out"


def _differences(found: Compared) -> list[str]:
    return [
        *(f"it lacks {spoken(f)}" for f in found.lacks),
        *(f"it has {spoken(f)}, which the bench has not" for f in found.has),
        *(f"the bench has {spoken(d.bench)}, the simulation {_numbers(d.simulation)}" for d in found.differs),
    ]


def _numbers(found: Found) -> str:
    return ", ".join(f"{name} = {value:.4g}" for name, value in found.parameters.items()) or "another"
