"""One session at the bench: several plans in turn, and the campaign they make."""

from collections.abc import Callable, Sequence
from pathlib import Path

from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.block import Campaign
from modallab.core.events import Event
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.pipelines.known_modes import with_known_modes
from modallab.storage import Store, campaign_of


def record_campaign(
    url: str, rig: Rig, plans: Sequence[Plan], data_folder: Path, notify: Callable[[Event], None]
) -> Campaign:
    """Run `plans` in turn on the bench at `url`, in its own process, and read back what was recorded.

    Args:
        url: address of the bench.
        rig: what stands on it.
        plans: what to do, in this order. A sine test that lengthens its bursts until they have settled, and names no
            modes, takes those of the impact test before it.
        data_folder: where the recordings are kept.
        notify: called with every event, as it comes.

    Raises:
        ModallabError: what ended a run early; the output is at zero and all acknowledged blocks are in the folder.
    """
    runs: list[str] = []
    with RigProcess(url, rig, data_folder) as process:
        for plan in plans:
            for event in process.run(with_known_modes(plan, lambda: _read_back(data_folder, runs))):
                if event.run not in runs:
                    runs.append(event.run)
                notify(event)
    return _read_back(data_folder, runs)


def _read_back(data_folder: Path, runs: Sequence[str]) -> Campaign:
    with Store(data_folder) as store:
        return campaign_of(store, runs)
