"""Writes python.md, the reference of `import modallab as ml`, from the docstrings; a test holds the page to it."""

import inspect
from pathlib import Path

import modallab

PAGE = Path(__file__).parent / "python.md"
HEAD = """# Python

What `import modallab as ml` offers to people at a notebook or a prompt. Importing it takes no time: what a function
needs is loaded when it is called. Every result shows itself in Jupyter, as a table or a figure, and in one line at a
prompt. Errors are those of [the reference](errors.md): each has `what`, `where` and `remedy`
([why the interface is made so](../decisions/0136-python-interface.md)). This page is written by
`python docs/reference/make_python.py`.
"""


def page() -> str:
    """The whole page."""
    names = [name for name in modallab.__all__ if not name.startswith("_")]
    functions = [name for name in names if inspect.isfunction(getattr(modallab, name)) or name == "frf"]
    classes = [name for name in names if name not in functions]
    parts = [HEAD, *(_function(name) for name in functions), *(_class(name) for name in classes)]
    return "\n".join(parts)


def _function(name: str) -> str:
    function = _plain(name)
    return f"## `ml.{name}{_signature(function)}`\n\n{_text(function)}\n"


def _plain(name: str) -> object:
    # Importing the package of the same name puts it in the function's place.
    from modallab.notebook.measured import frf

    return frf if name == "frf" else getattr(modallab, name)


def _class(name: str) -> str:
    kind = getattr(modallab, name)
    rows = [f"## `{name}`\n\n{_text(kind)}\n"]
    for member, found in vars(kind).items():
        if not member.startswith("_") and isinstance(found, property):
            rows.append(f"### `{name}.{member}`\n\n{_text(found)}\n")
        elif not member.startswith("_") and inspect.isfunction(found):
            rows.append(f"### `{name}.{member}{_signature(found)}`\n\n{_text(found)}\n")
    return "\n".join(rows)


def _signature(function: object) -> str:
    assert callable(function)
    parameters = inspect.signature(function).parameters.values()
    shown = [p.name if p.default is p.empty else f"{p.name}={p.default!r}" for p in parameters if p.name != "self"]
    stars = [i for i, p in enumerate(q for q in parameters if q.name != "self") if p.kind is p.KEYWORD_ONLY]
    if stars:
        shown.insert(stars[0], "*")
    return f"({', '.join(shown)})"


def _text(found: object) -> str:
    lines = (inspect.getdoc(found) or "").splitlines()
    text: list[str] = []
    for line in lines:
        if line in ("Args:", "Returns:", "Raises:", "Attributes:"):
            text += [f"{'Arguments' if line == 'Args:' else line[:-1]}:", ""]
        elif line.startswith("    ") and not line.startswith("     "):
            name, colon, rest = line.strip().partition(": ")
            text.append(f"- `{name}`: {rest}" if colon and " " not in name else f"- {line.strip()}")
        else:
            text.append(f"  {line.strip()}" if line.startswith(" ") else line)
    return "\n".join(text).strip()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
