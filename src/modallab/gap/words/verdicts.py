"""A verdict in one sentence: of a campaign, of a measured structure, of another program's simulation."""

from collections.abc import Sequence

from modallab.core.diagnosis import Diagnosis, FoundEffect, Gap, ResponseShare
from modallab.core.digits import list_in_words, percent_text, probability_text, share_text, three_digits
from modallab.core.effects import kind_of
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.gap.simulations.compare import SimulationComparison
from modallab.gap.words.effects import effect_in_words, effect_with_numbers, parameter_in_words

KNOWN = 2.0
"""Factor from before to after that is no matter of tolerances."""
NEXT_TO_NOTHING = 1e-6
ORDINARY = "(rms; 1 is ordinary)"


def verdict_sentence(diagnosis: Diagnosis, channels: Sequence[str] = ()) -> str:
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
        left = f"{gap.after:.2f} noise units including its revisions" if known else f"{gap.before:.2f} noise units"
        return f"Simulation and bench agree to within the {within}: the gap is {left}; 1 is noise alone."
    if diagnosis.verdict == "unknown":
        where = diagnosis.where
        at = f" on {', '.join(where.channels)}" if 0 < len(where.channels) < 4 else ""
        return (
            f"A gap of {three_digits(gap.before)} noise units lies in the {where.stage}{at}, and no known effect "
            f"explains it{_probability_in_words(diagnosis.unknown)}.{_behaviour_sentence(diagnosis)}"
        )
    parts = " and ".join(effect_in_words(f, channels) for f in diagnosis.effects)
    return (
        f"The gap of {three_digits(gap.before)} noise units comes from {parts}{_closes_gap(diagnosis.shrink.closed)}."
    )


def _closes_gap(share: float | None) -> str:
    return "" if share is None else f", which closes {share_text(share)} of the gap on held-out records"


def _behaviour_sentence(diagnosis: Diagnosis) -> str:
    """What a gap without a name behaves like, and how far that closes it."""
    described = diagnosis.described
    if described is None or described.shrink.closed is None:
        return ""
    return f" The gap behaves like {described.says.rstrip(',')}{_closes_gap(described.shrink.closed)}."


def gap_in_percent(gap: Gap) -> str:
    """The gap as a share of the response, in one sentence; "" where it is not known."""
    stages = (
        ("simulated from the rig file", gap.share_nominal),
        ("within the tolerances", gap.share_before),
        ("with the effects found", gap.share_after),
    )
    parts = [
        f"{_resonant_and_other(share)} {name}"
        for name, share in stages
        if share is not None and _resonant_and_other(share)
    ]
    whole = f"In percent of the response, at resonance and away from it: {'; '.join(parts)}." if parts else ""
    return " ".join(s for s in (whole, unexplained_sentence(gap)) if s)


def _resonant_and_other(share: ResponseShare) -> str:
    return list_in_words([share_of_response(v) for v in (share.at_resonance, share.away) if v is not None])


def share_of_response(share: float | None) -> str:
    """A share of the response with its noise taken off, which is never known to be nothing."""
    return percent_text(None if share is None else max(share, NEXT_TO_NOTHING))


def unexplained_sentence(gap: Gap) -> str:
    """What is left of the records beyond noise, in one sentence; "" where it is not known."""
    left = gap.discrepancy
    if left is None:
        return ""
    if not left.worst:
        return "Only noise is left of all records."
    return (
        f"Beyond noise, {share_of_response(left.median)} of a record is left unexplained (median); "
        f"at worst {share_of_response(left.worst)}, of {left.record}."
    )


def sentence_by_model(found: ModalDiagnosis) -> str:
    """The verdict on a structure that was compared with its modal model, with its probability."""
    before = f"{percent_text(found.before)} of the response differs"
    differs = f"{before}, by {found.strain_before:.2g} deviations of the tolerances"
    if found.verdict == "no_gap":
        return f"No gap beyond the tolerances{_probability_in_words(found.nothing)}: {differs} {ORDINARY}."
    if found.verdict == "unknown":
        return (
            f"A gap that no effect of the catalogue explains{_probability_in_words(found.unknown)}: {differs} "
            f"{ORDINARY}."
        )
    parts = " and ".join(effect_with_numbers(change) for change in found.effects)
    left = f"{percent_text(found.after)}, by {found.strain_after:.2g}"
    return f"{parts[0].upper()}{parts[1:]}. Without it {differs} {ORDINARY}; with it {left}."


def _probability_in_words(value: float | None) -> str:
    """Files of earlier versions state none."""
    return "" if value is None else f", probability {probability_text(value)}"


def sentence_of_simulation(found: SimulationComparison) -> str:
    """The verdict on a simulation that was compared with the bench."""
    before, after = three_digits(found.before), three_digits(found.after)
    if found.verdict == "no_gap":
        agree = f"No effect distinguishes simulation and bench: the gap is {before} noise units"
        return f"{agree}, {after} with the beam fitted to the bench."
    off = f"The simulation differs from the bench by {before} noise units"
    if found.verdict == "unknown":
        return f"{off}, and part of the difference stays unexplained."
    share = "" if found.closed is None else f"that closes {share_text(found.closed)} of the gap, "
    return (
        f"{off}: {'; '.join(_differences_in_words(found))}. Corrected, it is {after} off; {share}on "
        f"{_records_verdict(found)}."
    )


def _records_verdict(found: SimulationComparison) -> str:
    return f"{len(found.records)} held-out records"


def _differences_in_words(found: SimulationComparison) -> list[str]:
    return [
        *(f"it lacks {effect_in_words(f)}" for f in found.lacks),
        *(f"the simulation has {effect_in_words(f)}, which the bench lacks" for f in found.has),
        *(
            f"the bench has {effect_in_words(d.bench)}, the simulation {_numbers_in_words(d.simulation)}"
            for d in found.differs
        ),
    ]


def _numbers_in_words(found: FoundEffect) -> str:
    numbers = [f"{p.in_words} {parameter_in_words(found, p)[0]}" for p in kind_of(found.effect).parameters]
    return ", ".join(numbers) or "another"
