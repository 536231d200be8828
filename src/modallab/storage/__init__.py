"""Keeps what the device delivered: append-only, never rewritten, safe under kill -9."""

from modallab.storage.campaigns import campaign_of
from modallab.storage.recorder import Recorder
from modallab.storage.records import BlockNote, BlockRecord, Rates, RunRecord
from modallab.storage.store import Store, rig_hash

__all__ = ["BlockNote", "BlockRecord", "Rates", "Recorder", "RunRecord", "Store", "campaign_of", "rig_hash"]
