"""FRF and coherence of a run as far as it has come."""

from modallab.core.block import Block
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.broadband import broadband_frf, driven_band
from modallab.frf.estimate import convert, group_by_point, impact_frf
from modallab.frf.stepped import stepped_frf
from modallab.service.errors import ConflictError
from modallab.signals.full_scale import overloaded
from modallab.signals.signals import to_signals_of
from modallab.storage import Store

LOWEST_HZ = 0.5
USABLE = 0.4
"""Anti-alias filters hold the relation between channels up to this part of the rate."""


def live_frf(store: Store, run: str) -> Frf:
    """Mobility of a run's blocks that count now, with coherence where blocks are averaged.

    Raises:
        ConflictError: there is no block that counts yet.
        DataError, StorageError: blocks that cannot be used, or not be read.
    """
    record = store.catalogue.run(run)
    blocks = [block for block in store.blocks(run) if not overloaded(block, record.rig)]
    if not blocks:
        raise ConflictError(f"run {run} has no good block yet", where=run, remedy="wait for the first good block")
    of_test = _impact if record.test == "impact" else _sine if record.test == "sine" else _broadband
    frf = of_test(blocks, record.rig)
    return convert(frf, "mobility")


def _impact(blocks: list[Block], rig: Rig) -> Frf:
    groups = group_by_point(to_signals_of(blocks, rig))
    return impact_frf(groups, rig, (LOWEST_HZ, USABLE * blocks[0].rate_hz))


def _broadband(blocks: list[Block], rig: Rig) -> Frf:
    signals = to_signals_of([b for b in blocks if b.level == blocks[-1].level], rig)
    return broadband_frf(signals, rig, driven_band(signals))


def _sine(blocks: list[Block], rig: Rig) -> Frf:
    # One level only: FRFs of different levels are what is compared, never averaged.
    level = blocks[-1].level
    return stepped_frf(to_signals_of([b for b in blocks if b.level == level], rig), rig)
