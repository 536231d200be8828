"""Whether a notebook shows what its file says it shows."""

import json
import sys
from contextlib import chdir
from pathlib import Path
from typing import Any

from pages import ROOT
from transcript import difference

FOLDER = ROOT / "docs" / "notebooks"
sys.path.append(str(FOLDER))

from run_notebook import run  # noqa: E402


def notebook_differences(path: Path, folder: Path) -> list[str]:
    """Run a notebook in a folder; a text for each cell that shows something else."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    with chdir(folder):
        shown = run(notebook)
    pairs = zip(notebook["cells"], shown, strict=True)
    wrong = [difference(_text(cell.get("outputs", [])), _text(outputs)) for cell, outputs in pairs]
    return [f"{path.name}, cell {i}: {what}" for i, what in enumerate(wrong, 1) if what]


def _text(outputs: list[dict[str, Any]]) -> list[str]:
    """Text alone: pictures are looked at by people."""
    return [line for output in outputs for line in output.get("text", output.get("data", {}).get("text/plain", []))]
