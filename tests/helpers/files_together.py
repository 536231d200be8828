"""Which worker of pytest-xdist runs which test: a file to a worker, so that what its tests share is made once.

Held by names of tests, not by the marker of `--dist loadgroup`: pytest 9.2 no longer reads the names that pytest-xdist
3.8 gives to groups, and all fixtures were made anew by every worker.
"""

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

TOGETHER = ("page", "service/api", "service/campaigns", "service/process")
"""Folders whose files share a service: one worker runs them all."""
APART = (
    "docs/test_commands.py",
    "identification/test_more_data.py",
    "gap/test_corpus.py",
    "blind/test_trials_on_a_structure.py",
    "gap/test_selection.py",
    "service/process/test_a_session.py",
    "service/process/test_kills.py",
    "service/process/test_leaving.py",
    "cli/test_ctrl_c.py",
)
"""Files whose tests share nothing and are long: any worker runs the next."""


def group(nodeid: str) -> str:
    """What one worker runs: a file, all files of a folder that shares a service, or a test that shares nothing."""
    file = nodeid.partition("::")[0]
    name = file.partition("tests/")[2]
    if name in APART:
        return nodeid
    folder = name.rpartition("/")[0]
    return folder if folder in TOGETHER else file


class FilesTogether(LoadScopeScheduling):
    """Groups are given out in the order of the collection."""

    def _split_scope(self, nodeid: str) -> str:
        return group(nodeid)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> FilesTogether:
    return FilesTogether(config, log)
