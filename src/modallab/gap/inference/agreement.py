"""Whether the twin without effects agrees with records, and where it does not: within a second, from one hit on.

No cause is searched for. The scales of the discrepancy say by how much of its response each channel differs.
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.blas_threads import one_thread
from modallab.core.block import Campaign
from modallab.core.digits import percent_text
from modallab.core.errors import DataError
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.inference.baseline import without_effects
from modallab.gap.inference.posterior import Posterior
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.inference.view import RowModel
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.fitting import Bench

SENSOR = "Check sensitivity, direction, place, mount and cable there."


@dataclass(frozen=True, slots=True)
class Agreement:
    """How far the twin without effects agrees with records.

    Attributes:
        channels: name -> discrepancy as a share of the channel's response; channels without usable records are absent.
        frequencies: relative discrepancy of the natural frequencies; None where no hits show any.
        damping: the same of the damping ratios.
        tolerated: share of the response below which a discrepancy does not matter, from the rig file.
    """

    channels: dict[str, float]
    frequencies: float | None
    damping: float | None
    tolerated: float

    @property
    def differing(self) -> list[str]:
        """Names of the channels whose discrepancy exceeds the tolerance, the largest first."""
        found = [name for name, share in self.channels.items() if share > self.tolerated]
        return sorted(found, key=lambda name: -self.channels[name])

    @property
    def modes_differ(self) -> bool:
        """Whether the discrepancy of the modes exceeds the tolerance, on the scale of the modal constants."""
        return self.frequencies is not None and self.frequencies > DEFAULT.frequency_share * self.tolerated

    @property
    def agrees(self) -> bool:
        """Whether neither a channel nor the modes differ by more than is tolerated."""
        return not self.differing and not self.modes_differ

    @property
    def sentence(self) -> str:
        """What agrees, what does not, and what to check."""
        off = [f"{name} ({percent_text(self.channels[name])})" for name in self.differing]
        if self.frequencies is not None and self.damping is not None and self.modes_differ:
            return (
                f"Natural frequencies differ from the simulation by about {percent_text(self.frequencies)}, and "
                f"damping ratios by {percent_text(self.damping)}. Check the clamp, added masses and the beam of the "
                "rig file."
            )
        if not off:
            return (
                f"The simulation agrees with all {len(self.channels)} channels within "
                f"{percent_text(self.tolerated)} of "
                "their response."
            )
        if len(off) <= len(self.channels) // 2:
            return f"The response of {', '.join(off)} differs from the simulation; the other channels agree. {SENSOR}"
        return (
            f"The response of {len(off)} of {len(self.channels)} channels differs from the simulation, most that of "
            f"{off[0]}; the natural frequencies agree. Check the force sensor, the hit point and the timing."
        )


def records_of_last_setting(campaign: Campaign) -> Campaign:
    """The records of the last record's test and drive point alone: what stands on the bench now."""
    last = campaign.blocks[-1]
    return replace(
        campaign,
        blocks=tuple(b for b in campaign.blocks if (b.test, b.drive_point) == (last.test, last.drive_point)),
    )


@one_thread()
def agreement(campaign: Campaign) -> Agreement:
    """Compare records with the twin without effects, its tolerances fitted.

    Args:
        campaign: one record or more; the rig as believed.

    Raises:
        DataError: the records show no natural frequency and contain no sine test.
        RigError: the rig has no beam.
    """
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    rig = prepared.campaign.rig
    bench = problem_of_records(prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: False)
    if not bench.points and bench.data.sines is None:
        raise DataError(
            "no natural frequency could be identified in these records",
            where=rig.name,
            remedy="record another hit, harder or at another point",
        )
    return agreement_of(bench, *without_effects(bench))


def agreement_of(bench: Bench, view: RowModel, found: Posterior) -> Agreement:
    """What the scales of the discrepancy say.

    Args:
        bench: what was compared.
        view: its rows.
        found: the twin without effects, fitted to them.
    """
    rig = bench.data.rig
    scales = view.objective.values(found.levels)
    groups = view.objective.rows.group[np.isfinite(view.objective.rows.sigma)]
    share = {view.objective.rows.names[k]: float(scales[k]) for k in np.unique(groups)}
    tests = {c: [share[n] for n in (f"impact {c}", f"sine {c}") if n in share] for c in bench.data.channels}
    modes = share.get("poles")
    return Agreement(
        channels={rig.channels[c].name: max(each) for c, each in tests.items() if each},
        frequencies=None if modes is None else modes * DEFAULT.frequency_share,
        damping=None if modes is None else modes * DEFAULT.damping_share,
        tolerated=rig.tolerance.response,
    )
