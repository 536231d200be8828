"""Runs a notebook's cells in order and puts what they show into it.

    python docs/notebooks/run_notebook.py NOTEBOOK.ipynb

It does what a kernel does with cells of plain Python, and needs none; the tests run the notebooks by it.
"""

import ast
import base64
import io
import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

DPI = 45


def run(notebook: dict[str, Any]) -> list[list[dict[str, Any]]]:
    """The outputs of every cell, in the notebook format; a cell that fails raises what it raised."""
    names: dict[str, Any] = {"__name__": "__main__"}
    shown: list[list[dict[str, Any]]] = []
    count = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            count += 1
            shown.append(_cell("".join(cell["source"]), names, count))
        else:
            shown.append([])
    return shown


def _cell(source: str, names: dict[str, Any], count: int) -> list[dict[str, Any]]:
    *body, last = ast.parse(source).body
    printed, value = io.StringIO(), None
    with redirect_stdout(printed):
        exec(compile(ast.Module(body, []), "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
        else:
            exec(compile(ast.Module([last], []), "<cell>", "exec"), names)
    said: list[dict[str, Any]] = []
    if printed.getvalue():
        said.append({"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(keepends=True)})
    if value is not None:
        data = _data(value)
        said.append({"output_type": "execute_result", "execution_count": count, "metadata": {}, "data": data})
    return said


def _data(value: Any) -> dict[str, Any]:
    data: dict[str, Any] = {"text/plain": repr(value).splitlines(keepends=True)}
    html = getattr(value, "_repr_html_", None)
    if html is not None and not hasattr(value, "savefig"):
        data["text/html"] = html().splitlines(keepends=True)
    if hasattr(value, "savefig"):
        picture = io.BytesIO()
        value.savefig(picture, format="png", dpi=DPI)
        data["image/png"] = base64.b64encode(picture.getvalue()).decode()
    return data


def main(path: Path) -> None:
    """Run a notebook in its own place and write it with its outputs."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    count = 0
    for cell, outputs in zip(notebook["cells"], run(notebook), strict=True):
        if cell["cell_type"] == "code":
            count += 1
            cell |= {"outputs": outputs, "execution_count": count}
    path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
