"""One service and one browser for all tests of the page."""

from collections.abc import Callable, Iterator

import pytest
from page_browser import BENCH, PICTURES, SHOWN_BENCH, Watched, browsing, chromium
from playwright.sync_api import Browser
from service_process import ServiceProcess

Open = Callable[..., Watched]


@pytest.fixture(scope="session")
def program() -> str:
    found = chromium()
    if found is None:
        pytest.skip("this machine has no chromium: install it to test the page")
    return found


@pytest.fixture(scope="module")
def browser(program: str) -> Iterator[Browser]:
    """Not for longer than a module: as long as it is driven its event loop is the thread's; others need their own."""
    with browsing(program) as started:
        yield started


# For each file anew: what one file records in a campaign would be models and workbenches on the pages of another.
# Not for the session: a service that nobody asks any more would take a twentieth of a processor from all other tests.
@pytest.fixture(scope="module")
def served(program: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServiceProcess]:
    bench = SHOWN_BENCH if PICTURES else BENCH
    with ServiceProcess(tmp_path_factory.mktemp("page") / "data", "--workers", "1", bench=bench) as started:
        yield started


@pytest.fixture
def operator(browser: Browser, served: ServiceProcess) -> Iterator[Open]:
    """Opens the page, logged in; at the end nothing may have gone wrong in any."""
    opened: list[Watched] = []

    def open_page(**options: object) -> Watched:
        opened.append(Watched(browser, served.url + served.client.login_link().path, **options))
        return opened[-1]

    yield open_page
    for one in opened:
        one.close()
    assert [wrong for one in opened for wrong in one.wrong] == []
