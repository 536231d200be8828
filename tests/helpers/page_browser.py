"""A browser without a window that shows the operator's page, and notes what it must never do."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from urllib.parse import urlsplit

from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
NAMED = "try { localStorage.setItem('modallab.operator', 'Ada') } catch {}"
"""The service's own token does not say who works with it. A report that opens has no storage."""
LONG_SINE = {
    "sine-frequencies_hz": ", ".join(map(str, range(20, 60))),
    "sine-settle_s": "40",
    "sine-wait_s": "0.2",
}
"""A test that goes on for as long as anything may be done to it."""
BENCH = (
    "sim://cantilever?seed=32&zeta=0.01&bad_hits=0.3&pace=1&speed=20&reaction_s=0.1,0.2"
    "&effect=added_mass,mass=0.04,x=0.63"
)
"""The first hit is a bad one and the next are good; samples come faster than the clock; the rig
file knows of no mass."""

PICTURES = os.environ.get("MODALLAB_PICTURES", "")
"""Folder to which the tests write what they see; none by default. The bench then is as slow as a person."""
SHOWN_BENCH = BENCH.replace("speed=20", "speed=4").replace("reaction_s=0.1,0.2", "reaction_s=0.5,0.8")


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
        self.page.set_default_timeout(120_000)
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

    def picture(self, name: str, *, whole: bool = True) -> None:
        """A picture for the documentation, where one is asked for."""
        if PICTURES:
            self.page.evaluate("scrollTo(0, 0)")
            self.page.wait_for_timeout(500 if whole else 0)
            content = self.page.screenshot(full_page=whole)
            picture = Image.open(BytesIO(content)).convert("P", palette=Image.Palette.ADAPTIVE, colors=64)
            picture.save(Path(PICTURES) / f"page-{name}.png", optimize=True)

    def close(self) -> None:
        """Leave."""
        self.context.close()

    def _look(self, url: str) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("blob", "data", "about") and parts.hostname != "127.0.0.1":
            self.wrong.append(f"asked {url}")

    def _count(self, length: str) -> None:
        self.bytes += int(length)
