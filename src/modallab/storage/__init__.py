"""Keeps what the device delivered: append-only, never rewritten, safe under kill -9."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.storage.campaigns import campaign_of
    from modallab.storage.recorder import Recorder
    from modallab.storage.records import BlockNote, BlockRecord, RunRecord, SamplingRates
    from modallab.storage.store import Store, rig_hash

__all__ = ["BlockNote", "BlockRecord", "Recorder", "RunRecord", "SamplingRates", "Store", "campaign_of", "rig_hash"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "campaigns": ("campaign_of",),
        "recorder": ("Recorder",),
        "records": ("BlockNote", "BlockRecord", "SamplingRates", "RunRecord"),
        "store": ("Store", "rig_hash"),
    },
)
