"""The built documentation: every page, a search that needs no server, and nothing from elsewhere."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import PAGES, ROOT

DOCS = ROOT / "docs"
_FETCHED = re.compile(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=[\"'](https?:|//)", re.IGNORECASE)


def _build(docs: Path, out: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, docs / "site.py", out], capture_output=True, text=True, check=False)


@pytest.mark.thorough("builds all pages, 10 s")
def test_all_pages_are_built_and_found_without_a_network(tmp_path: Path) -> None:
    done = _build(DOCS, tmp_path / "site")
    assert done.returncode == 0, done.stderr
    site = tmp_path / "site"
    wanted = [p.relative_to(DOCS) for p in (*PAGES, *DOCS.glob("notebooks/*.ipynb")) if p.is_relative_to(DOCS)]
    built = {p.relative_to(site).with_suffix("").as_posix().replace("index", "README") for p in site.rglob("*.html")}
    assert {p.with_suffix("").as_posix() for p in wanted} <= built
    assert "noise units" in (site / "explanation/gap.html").read_text(encoding="utf-8")
    assert "<table" in (site / "notebooks/gap.html").read_text(encoding="utf-8")
    for page, holds in (
        ("python", "ml.identify"),
        ("command-line", "--response-only"),
        ("rig-file", "sensitivity_v_per_unit"),
    ):
        assert holds in (site / f"reference/{page}.html").read_text(encoding="utf-8"), page
    assert "frequency_hz" in (site / "reference/rest-frame.html").read_text(encoding="utf-8")
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    assert "explanation/gap" in index
    assert "mobil" in index
    assert not [p for p in site.rglob("*.html") if _FETCHED.search(p.read_text(encoding="utf-8"))]


@pytest.mark.thorough("builds pages")
def test_a_link_that_leads_nowhere_ends_the_build(tmp_path: Path) -> None:
    docs = tmp_path / "docs"
    for name in ("site.py", "made.py", "history", "notebooks", "decisions", "reference/openapi.json", "tutorial"):
        target = docs / name
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (DOCS / name).is_dir() else shutil.copyfile)(DOCS / name, target)
    (docs / "README.md").write_text("# Pages\n\n- [one](one.md)\n", encoding="utf-8")
    (docs / "one.md").write_text("# One\n\n[gone](gone.md)\n", encoding="utf-8")
    done = _build(docs, tmp_path / "site")
    assert done.returncode != 0
    assert "gone" in done.stderr
    assert not (tmp_path / "site").exists()
