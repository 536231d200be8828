"""README and pages do what they say: every block is run, or says why not.

The pages that build on each other share a folder; what a page's blocks need besides is made for it here.
"""

import shutil
from pathlib import Path

import pytest
from notebooks import notebook_differences
from page_preparations import PREPARED, nothing
from page_walk import Walk
from pages import ELSEWHERE, HOW_TO, PAGES, ROOT, fenced, name, to_run

pytestmark = pytest.mark.thorough("runs all commands of the pages")

TOGETHER = (
    ("README.md",),
    (HOW_TO + "close-the-gap.md",),
    (HOW_TO + "first-connection.md", HOW_TO + "strike-at-the-terminal.md"),
    ("docs/tutorial/first-test.md", HOW_TO + "identify-a-band.md"),
)
"""Pages that are walked in one folder each; all others share the last."""

SERVE = "modallab serve --rig rig.yaml --data lab-data"
SERVES = {SERVE, f"{SERVE} --open"}
"""What `tests/service/process/test_queue_outlives.py` starts."""


def _pages() -> list[tuple[str, ...]]:
    own = [page for group in TOGETHER for page in group]
    others = [name(p) for p in PAGES if to_run(p) and name(p) not in own and name(p) not in ELSEWHERE]
    return [*TOGETHER, tuple(sorted(others, key=lambda n: (n.startswith("docs/reference"), n)))]


@pytest.mark.parametrize("pages", _pages(), ids=lambda group: Path(group[0]).stem)
def test_every_block_does_what_its_page_says(
    pages: tuple[str, ...], tmp_path: Path, demo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    wrong: list[str] = []
    # The demo is run once for all tests.
    shutil.copytree(demo, tmp_path / "demo")
    printed = {"modallab demo --out demo": (demo.parent / "printed.txt").read_text(encoding="utf-8").splitlines()}
    for page in pages:
        with PREPARED.get(page, nothing)(tmp_path) as made:
            ran = SERVES | made.pop("ran", set())
            wrong += Walk(tmp_path, printed, ran=ran, **made).wrong(fenced(ROOT / page))
    if pages[0] == "README.md":
        # It opens what the README has recorded and diagnosed.
        wrong += notebook_differences(ROOT / "docs/notebooks/gap.ipynb", tmp_path)
    assert not wrong, "\n\n".join(wrong)
