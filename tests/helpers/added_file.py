"""The file that a how-to page adds, put where the page says it goes."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import invalidate_caches
from pathlib import Path
from types import ModuleType

from pages import ROOT, fenced


def write_example(page: str, file: Path) -> None:
    """The first Python block of docs/how-to/`page`, as `file`."""
    block = next(b for b in fenced(ROOT / "docs/how-to" / page) if b.language == "python")
    file.write_text("\n".join(block.lines) + "\n", encoding="utf-8")
    invalidate_caches()


@contextmanager
def added(package: ModuleType, folder: Path) -> Iterator[None]:
    """Files of `folder` as if they were in the folder of `package`."""
    before = list(package.__path__)
    package.__path__ = [*before, str(folder)]
    try:
        yield
    finally:
        package.__path__ = before
        for file in folder.glob("*.py"):
            sys.modules.pop(f"{package.__name__}.{file.stem}", None)
