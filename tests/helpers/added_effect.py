"""The effect that the how-to page adds, put where the program looks for effects, for as long as a test needs it."""

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import modallab.twin.effects as twin
import modallab_simulators.cantilever.effects as bench
from modallab.core.effects import catalogue

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-an-effect.md"
NAME = "slope_spring"


def page_files() -> tuple[str, str]:
    """The twin's file and the simulated bench's, as the page has them."""
    text = PAGE.read_text(encoding="utf-8")
    found = dict(re.findall(r"^`(\S+)`:\n\n```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    return (
        found[f"src/modallab/twin/effects/{NAME}.py"],
        found[f"simulators/modallab_simulators/cantilever/effects/{NAME}.py"],
    )


@contextmanager
def added(folder: Path, twin_file: str | None, bench_file: str | None) -> Iterator[None]:
    """With these files, or without one of them, among the modules of the effects."""
    packages = ((twin, twin_file), (bench, bench_file))
    for package, text in packages:
        own = folder / package.__name__
        own.mkdir()
        if text is not None:
            (own / f"{NAME}.py").write_text(text, encoding="utf-8")
        package.__path__.append(str(own))
    _forget()
    try:
        yield
    finally:
        for package, _ in packages:
            package.__path__.pop()
            sys.modules.pop(f"{package.__name__}.{NAME}", None)
            package.__dict__.pop(NAME, None)
        _forget()


def _forget() -> None:
    for known in (twin.effect_models, bench.effect_parts, catalogue):
        known.cache_clear()
