"""A browser without a window that shows the operator's page, and notes what it must never do."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
NAMED = "if (location.protocol !== 'about:') localStorage.setItem('modallab.operator', 'Ada')"
"""The service's own token does not say who works with it."""
BENCH = "sim://cantilever?seed=3&zeta=0.05&bad_hits=0.8&pace=1&speed=6&reaction_s=0.1,0.2"
"""In its order of hits a bad one comes early, and samples come faster than the clock."""


def chromium() -> str | None:
    """The browser of this machine, if it has one."""
    return next(filter(None, map(shutil.which, PROGRAMS)), None)


@contextmanager
def browsing(program: str) -> Iterator[Browser]:
    """The browser, started once."""
    with sync_playwright() as playwright:
        # Its sandbox cannot be had as root, nor is it needed for pages of our own.
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield browser
        browser.close()


class Watched:
    """One person's browser, logged in by a link; `wrong` is what a page must not do."""

    def __init__(self, browser: Browser, link: str, **options: object) -> None:
        self.wrong: list[str] = []
        self.bytes = 0
        self.context: BrowserContext = browser.new_context(**options)  # type: ignore[arg-type]
        self.context.add_init_script(NAMED)
        self.context.on("request", lambda request: self._look(request.url))
        self.context.on("weberror", lambda error: self.wrong.append(f"error: {error.error}"))
        self.context.on("console", lambda m: self.wrong.append(f"console: {m.text}") if m.type == "error" else None)
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(30_000)
        self.page.on("websocket", lambda socket: self._look(socket.url))
        self.page.on("response", lambda response: self._count(response.headers.get("content-length", "0")))
        self.page.goto(link)
        self.page.wait_for_selector("h1:has-text('Bench')")

    def view(self, name: str) -> None:
        """Go to a view by its link."""
        self.page.click(f"nav a:has-text('{name}')")
        self.page.wait_for_selector(f"h1:has-text('{name}')")

    def begin(self, view: str, fields: dict[str, str]) -> None:
        """Fill the form of a test, and begin it."""
        self.view(view)
        self.page.wait_for_selector("form.plan, .prompt")
        if not self.page.query_selector("form.plan"):
            self.page.click("text=New test")
        for name, text in fields.items():
            self.page.fill(f"#f-{name}", text)
        self.page.click("form.plan button.main:enabled")

    def shoot(self, file: Path, *, whole: bool = False) -> None:
        """A picture of it."""
        self.page.screenshot(path=file, full_page=whole)

    def close(self) -> None:
        """Leave."""
        self.context.close()

    def _look(self, url: str) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("blob", "data", "about") and parts.hostname != "127.0.0.1":
            self.wrong.append(f"asked {url}")

    def _count(self, length: str) -> None:
        self.bytes += int(length)
