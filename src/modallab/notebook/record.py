"""Records a campaign in a process of its own: `python -m modallab.notebook.record FOLDER`.

The folder holds the order; the campaign, or the error, is left there. What is printed is how far it is.
"""

import pickle
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from modallab.core.documents.pages import EventView
from modallab.core.errors import ModallabError
from modallab.formats.campaign.campaign_hdf5 import write_campaign


def main(folder: Path) -> int:
    """Record what the order says; 0 if it was done."""
    # Asked to end, it leaves the bench as Ctrl-C does: at rest.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # Not above: the bench's own process reads this module too, and needs none of it.
    from modallab.service.campaigns.local_session import record_campaign

    url, rig, plans = pickle.loads((folder / "order.pickle").read_bytes())
    try:
        write_campaign(
            record_campaign(url, rig, plans, folder / "data", _progress_reporter(len(plans))), folder / "campaign.h5"
        )
    except ModallabError as error:
        (folder / "error.pickle").write_bytes(pickle.dumps(error))
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


def _progress_reporter(plans: int) -> Callable[[EventView], None]:
    runs: list[str] = []

    def notify(event: EventView) -> None:
        if event.kind == "progress":
            if event.run not in runs:
                runs.append(event.run)
            said = event.content
            share = (runs.index(event.run) + said["done"] / max(said["total"], 1)) / plans
            print(f"{share:.4f} {said['what']}", flush=True)

    return notify


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
