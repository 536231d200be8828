"""The parts of the reference that the program itself says; `site.py` puts them into the pages.

A page holds the line ``*(`docs/made.py` writes `NAME` here.)*``, or `fields module.Class` for `NAME`.

    python docs/made.py PAGE.md    prints a page with its parts
"""

import argparse
import inspect
import json
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

MARK = re.compile(r"^\*\(`docs/made\.py` writes `(\w+)(?: ([\w.]+))?` here\.\)\*$", re.MULTILINE)
RAISED_ELSEWHERE = (
    "modallab.acquisition.process.rig_process",
    "modallab.cli.demo",
    "modallab.cli.serve",
    "modallab.service.api.problems",
    "modallab_drivers.replay",
)
"""Modules with errors of their own, which nothing else here imports."""


def filled(text: str) -> str:
    """A page with its parts in the place of their marks."""
    return MARK.sub(lambda mark: PARTS[mark[1]](*filter(None, [mark[2]])), text)


def table(heads: str, rows: Iterable[Iterable[object]]) -> str:
    """A table in Markdown; heads are separated by bars."""
    lines = [" | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in row) for row in rows]
    rule = "|".join("---" for _ in heads.split("|"))
    return "\n".join([f"| {heads} |", f"|{rule}|", *(f"| {line} |" for line in lines)])


def commands() -> str:
    """Every command with its options, as `--help` has them."""
    from modallab.cli.parser import build_parser

    return "\n\n".join(_command(path, said, parser) for path, said, parser in _commands(build_parser("0")))


def _commands(parser: Any, path: str = "modallab") -> Iterator[tuple[str, str, Any]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            said = {choice.dest: choice.help for choice in action._choices_actions}
            for name, sub in action.choices.items():
                yield f"{path} {name}", said[name], sub
                yield from _commands(sub, f"{path} {name}")


def _command(path: str, said: str, parser: Any) -> str:
    actions = [a for a in parser._actions if not isinstance(a, argparse._SubParsersAction | argparse._HelpAction)]
    title = f"## `{path}`\n\n{said[:1].upper()}{said[1:]}."
    if not actions:
        return title
    form = parser._get_formatter()
    rows = [(f"`{_written(a, form)}`", _default(a), form._expand_help(a)) for a in actions]
    return f"{title}\n\n{table('option | default | meaning', rows)}"


def _written(action: Any, form: Any) -> str:
    if not action.option_strings:
        return form._metavar_formatter(action, action.dest)(1)[0]
    value = "" if action.nargs == 0 else form._format_args(action, action.dest.upper())
    return f"{', '.join(action.option_strings)} {value}".strip()


def _default(action: Any) -> str:
    plain = action.default in (None, False, "", argparse.SUPPRESS) or "(default" in (action.help or "")
    return "needed" if action.required and action.option_strings else "" if plain else str(action.default)


def estimators() -> str:
    """The estimators there are."""
    from modallab.identification import estimator_names, find_estimator

    heads = "`--method` | what it does | lines | order | brings | refined | source"
    return table(heads, (_estimator(find_estimator(name)) for name in estimator_names()))


def _estimator(one: Any) -> tuple[str, ...]:
    order = one.order
    limits = "" if order is None else f"{order.meaning}, {order.lowest} to {order.highest}; by default {order.default}"
    refined = "yes" if one.refined else "no"
    return f"`{one.name}`", one.description, one.grid, limits, ", ".join(one.brings), refined, one.source


def formats() -> str:
    """The formats there are."""
    from modallab.formats import all_formats

    return table("name | what it is | endings | holds | read, written | may need", map(_format, all_formats()))


def _format(one: Any) -> tuple[str, ...]:
    from modallab.formats.asked import ASKED

    does = ", ".join(word for word, there in (("read", one.read), ("written", one.write)) if there)
    asks = ", ".join(f"`--{(ASKED[option].called or option).replace('_', '-')}`" for option in one.asks)
    endings = ", ".join(f"`{ending}`" for ending in one.endings)
    return f"`{one.name}`", one.description, endings, ", ".join(one.holds), does, asks or "nothing"


def errors() -> str:
    """Every kind of error."""
    from modallab.core.errors import ModallabError

    for module in RAISED_ELSEWHERE:
        import_module(module)
    own = [kind for kind in _kinds(ModallabError) if kind.__module__.startswith("modallab") and "code" in vars(kind)]
    return table("code | class | meaning", ((f"`{k.code}`", f"`{k.__name__}`", _first(k)) for k in own))


def _kinds(kind: type[Any]) -> list[type[Any]]:
    return [kind, *(found for sub in kind.__subclasses__() for found in _kinds(sub))]


def _first(found: object) -> str:
    return (inspect.getdoc(found) or "").partition("\n\n")[0].replace("\n", " ")


def problems() -> str:
    """Every kind of a problem that the service answers with."""
    from modallab.service.api.problems import problem_kinds

    rows = ((f"`{kind.code}`", kind.status, kind.title, kind.meaning) for kind in problem_kinds().values())
    return table("code | status | title | meaning", rows)


def settings() -> str:
    """The settings of the service."""
    from modallab.core.frozen import described_fields
    from modallab.core.settings import Settings

    of = described_fields(Settings)[1]
    rows = ((f"`MODALLAB_{n.upper()}`", _shown(f.default), of[n]) for n, f in Settings.model_fields.items())
    return table("variable | default | meaning", rows)


def events() -> str:
    """The kinds of events."""
    document = json.loads((Path(__file__).parent / "reference/asyncapi.json").read_text(encoding="utf-8"))
    messages = document["components"]["messages"].values()
    return table("kind | meaning", ((f"`{m['name']}`", m["summary"]) for m in messages if "contentType" not in m))


def fields(name: str) -> str:
    """The fields of a document, and of the documents inside it."""
    module, _, kind = name.rpartition(".")
    document = getattr(import_module(module), kind)
    schema = document.model_json_schema()
    inside = schema.get("$defs", {})
    parts = [_fields(schema, document)]
    parts += [f"**{title}.** {_said(of)}\n\n{_fields(of)}" for title, of in inside.items() if "properties" in of]
    return "\n\n".join(parts)


def _fields(schema: dict[str, Any], document: Any = None) -> str:
    rows: list[tuple[str, str, str]] = []
    for name, field in schema["properties"].items():
        if "const" in field:
            continue
        default = document.model_fields[name].get_default(call_default_factory=True) if document else None
        default = field.get("default", default)
        needed = name in schema.get("required", ())
        rows.append((f"`{name}`", "needed" if needed else _shown(default), _meaning(field)))
    return table("field | default | meaning", rows)


def _said(schema: dict[str, Any]) -> str:
    return schema.get("description", "").replace("\n", " ")


def _meaning(field: dict[str, Any]) -> str:
    said, text = _said(field), json.dumps(field)
    choices = re.findall(r'"enum": \[([^\]]*)\]', text)
    kinds = dict.fromkeys(re.findall(r'"#/\$defs/(\w+)"', text))
    one_of = f" One of {', '.join(f'`{c}`' for c in json.loads(f'[{choices[0]}]'))}." if choices else ""
    return f"{said}{one_of}{''.join(f' See {kind}.' for kind in kinds)}"


def _shown(default: object) -> str:
    if default in (None, "") or str(default) in ("PydanticUndefined", "[]", "()", "{}"):
        return ""
    if isinstance(default, list | tuple) and len(default) > 4:
        return f"{len(default)} numbers"
    if (isinstance(default, dict) and len(default) > 2) or hasattr(default, "model_fields"):
        return "see below"
    return f"`{default}`" if isinstance(default, str) else str(default)


def python() -> str:
    """What `import modallab as ml` offers, from the docstrings."""
    import modallab

    names = [name for name in modallab.__all__ if not name.startswith("_")]
    functions = [name for name in names if inspect.isfunction(getattr(modallab, name)) or name == "frf"]
    classes = [name for name in names if name not in functions]
    return "\n".join([*map(_function, functions), *map(_class, classes)])


def _function(name: str) -> str:
    import modallab
    from modallab.notebook.measured_frf import frf

    # Importing the package of the same name puts it in the function's place.
    function = frf if name == "frf" else getattr(modallab, name)
    return f"## `ml.{name}{_signature(function)}`\n\n{_text(function)}\n"


def _class(name: str) -> str:
    import modallab

    kind = getattr(modallab, name)
    rows = [f"## `{name}`\n\n{_text(kind)}\n"]
    for member, found in vars(kind).items():
        if not member.startswith("_") and isinstance(found, property):
            rows.append(f"### `{name}.{member}`\n\n{_text(found)}\n")
        elif not member.startswith("_") and inspect.isfunction(found):
            rows.append(f"### `{name}.{member}{_signature(found)}`\n\n{_text(found)}\n")
    return "\n".join(rows)


def _signature(function: Callable[..., Any]) -> str:
    parameters = [p for p in inspect.signature(function).parameters.values() if p.name != "self"]
    shown = [p.name if p.default is p.empty else f"{p.name}={p.default!r}" for p in parameters]
    stars = [i for i, p in enumerate(parameters) if p.kind is p.KEYWORD_ONLY]
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


def decisions(numbers: str) -> str:
    """The titles of decisions, given their numbers with dots between."""
    pages = [next(Path(__file__).parent.glob(f"decisions/{number}-*.md")) for number in numbers.split(".")]
    titles = [page.read_text(encoding="utf-8").partition("\n")[0].partition(": ")[2] for page in pages]
    return "\n".join(f"- [{title}]({page.name})" for title, page in zip(titles, pages, strict=True))


_ALL = (commands, decisions, errors, estimators, events, fields, formats, problems, python, settings)
PARTS: dict[str, Callable[..., str]] = {part.__name__: part for part in _ALL}

if __name__ == "__main__":
    print(filled(Path(sys.argv[1]).read_text(encoding="utf-8")))
