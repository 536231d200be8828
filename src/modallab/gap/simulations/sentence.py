"""What was found of a simulation, in words."""

from modallab.core.diagnosis import Found
from modallab.core.rounded import rounded
from modallab.gap.report.summary import spoken
from modallab.gap.simulations.compare import Compared


def sentence_of(found: Compared) -> str:
    """The verdict in one sentence."""
    if found.verdict == "no_gap":
        return f"No effect parts simulation and bench: the gap is {rounded(found.before)} noise units, {_after(found)}."
    if found.verdict == "unknown":
        return f"The simulation is {rounded(found.before)} noise units off the bench, and not all of that is explained."
    off = f"The simulation is {rounded(found.before)} noise units off the bench"
    return f"{off}: {'; '.join(_parts(found))}. {_how_far(found)}"


def _parts(found: Compared) -> list[str]:
    return [
        *(f"it lacks {spoken(f)}" for f in found.lacks),
        *(f"it has {spoken(f)}, which the bench has not" for f in found.has),
        *(f"the bench has {spoken(d.bench)}, the simulation {_numbers(d.simulation)}" for d in found.differs),
    ]


def _numbers(found: Found) -> str:
    return ", ".join(f"{name} = {value:.4g}" for name, value in found.parameters.items()) or "another"


def _after(found: Compared) -> str:
    return f"{rounded(found.after)} with the beam's numbers as the bench has them"


def _how_far(found: Compared) -> str:
    share = "" if found.closed is None else f"that is {found.closed:.1%} of it closed, "
    return f"Corrected, it is {rounded(found.after)} off; {share}on {len(found.records)} records held out."
