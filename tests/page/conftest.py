"""The service and a browser, for all tests of the page."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from page_browser import BENCH, Watched, browsing, chromium
from playwright.sync_api import Browser
from service_process import ServiceProcess


@pytest.fixture(scope="session")
def program() -> str:
    found = chromium()
    if found is None:
        pytest.skip("this machine has no chromium: install it to test the page")
    return found


@pytest.fixture
def browser(program: str) -> Iterator[Browser]:
    """For one test only: as long as it is driven its event loop is the thread's, and other tests need their own."""
    with browsing(program) as started:
        yield started


@pytest.fixture(scope="module")
def served(program: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServiceProcess]:
    folder: Path = tmp_path_factory.mktemp("page") / "data"
    with ServiceProcess(folder, "--no-jobs", bench=BENCH) as started:
        yield started


@pytest.fixture
def operator(browser: Browser, served: ServiceProcess) -> Iterator[Callable[..., Watched]]:
    """Opens the page, logged in; at the end nothing may have gone wrong in any."""
    opened: list[Watched] = []

    def open_page(**options: object) -> Watched:
        opened.append(Watched(browser, served.url + served.client.login_link().path, **options))
        return opened[-1]

    yield open_page
    for one in opened:
        one.close()
    assert [wrong for one in opened for wrong in one.wrong] == []
