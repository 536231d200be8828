"""How long the tests of a run take together, and whether a few of them take most of it.

Given `--slowest-share 1/3`, a run fails whose slowest 20 tests take more than a third of the time of all. Times are
those of a test with the fixtures that it was the first to ask for, summed over pytest's worker processes.
"""

from collections import Counter
from fractions import Fraction

import pytest

SLOWEST = 20


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--slowest-share",
        type=Fraction,
        metavar="SHARE",
        help=f"fail where the slowest {SLOWEST} tests take more than this share of the summed time, as 1/3",
    )


def pytest_configure(config: pytest.Config) -> None:
    share = config.getoption("slowest_share")
    if share is not None and not hasattr(config, "workerinput"):
        config.pluginmanager.register(SlowestTests(share))


class SlowestTests:
    """Seconds by test, as the process that hears of all tests counts them.

    Args:
        share: of the summed time, what the slowest tests may take.
    """

    def __init__(self, share: Fraction) -> None:
        self.share = share
        self.seconds: Counter[str] = Counter()

    @property
    def total_s(self) -> float:
        return sum(self.seconds.values())

    @property
    def slowest_s(self) -> float:
        return sum(seconds for _, seconds in self.seconds.most_common(SLOWEST))

    @property
    def uneven(self) -> bool:
        return self.slowest_s > self.share * self.total_s

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] += report.duration

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self.uneven and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        say = terminalreporter.write_line
        parts = f"the slowest {SLOWEST} of them {self.slowest_s:.0f} s, of at most {self.share} of it"
        say(f"{len(self.seconds)} tests took {self.total_s:.0f} s together, {parts}")
        if self.uneven:
            for name, seconds in self.seconds.most_common(SLOWEST):
                say(f"{seconds:8.2f} s {name}")
            say("the slowest tests take too large a share: make them faster, or mark them `thorough` with the reason")
