"""The reference of `import modallab as ml` is that of its docstrings."""

import runpy

from pages import ROOT


def test_the_page_is_what_the_docstrings_say() -> None:
    """To take over a change: python docs/reference/make_python.py."""
    script = runpy.run_path(str(ROOT / "docs" / "reference" / "make_python.py"))
    assert script["PAGE"].read_text(encoding="utf-8") == script["page"]()
