"""One visit to the bench: several plans in turn, and the campaign they make."""

from collections.abc import Callable, Sequence
from pathlib import Path

from modallab.acquisition.process import RigProcess
from modallab.schema.block import Campaign
from modallab.schema.events import Event
from modallab.schema.plan import Plan
from modallab.schema.rig import Rig
from modallab.storage import Store, campaign_of
from modallab.tasks.known_modes import with_modes_of_visit


def record_campaign(
    url: str, rig: Rig, plans: Sequence[Plan], data_folder: Path, tell: Callable[[Event], None]
) -> Campaign:
    """Run `plans` in turn on the bench at `url`, in its own process, and read back what was recorded.

    Args:
        url: address of the bench.
        rig: what stands on it.
        plans: what to do, in this order. A sine test that lengthens its bursts until they have settled, and names no
            modes, takes those of the impact test before it.
        data_folder: where the recordings are kept.
        tell: called with every event, as it comes.

    Raises:
        ModallabError: what ended a run early; the output is at zero and all acknowledged blocks are in the folder.
    """
    runs: list[str] = []
    with RigProcess(url, rig, data_folder) as process:
        for plan in plans:
            for event in process.run(with_modes_of_visit(plan, lambda: _read_back(data_folder, runs))):
                if event.run not in runs:
                    runs.append(event.run)
                tell(event)
    return _read_back(data_folder, runs)


def _read_back(data_folder: Path, runs: Sequence[str]) -> Campaign:
    with Store(data_folder) as store:
        return campaign_of(store, runs)
