"""Writes into the reference pages what estimators and formats declare of themselves; a test holds the pages to it."""

import re
from pathlib import Path

from modallab.formats import all_formats, writers
from modallab.identification import Estimator, estimator_names, find_estimator

HERE = Path(__file__).parent
OPTIONS = {"window_s": "window", "variables": "variable", "array_map": "map"}
"""Of the command line, where it calls what is asked otherwise."""


def pages() -> dict[Path, str]:
    """Each page that lists estimators or formats, as it should be."""
    commands = (HERE / "command-line.md").read_text(encoding="utf-8")
    commands = _choices(commands, "modallab identify", "--method", estimator_names())
    commands = _choices(commands, "modallab export", "--format", tuple(f.name for f in writers()))
    return {
        HERE / "command-line.md": commands,
        HERE / "estimators.md": _between(HERE / "estimators.md", estimator_table()),
        HERE / "formats.md": _between(HERE / "formats.md", format_table()),
    }


def estimator_table() -> str:
    """The estimators there are, a row each."""
    rows = [
        "| `--method` | what it does | lines | order | brings | refined | source |",
        "|---|---|---|---|---|---|---|",
    ]
    return "\n".join([*rows, *(_estimator(find_estimator(name)) for name in estimator_names())])


def _estimator(one: Estimator) -> str:
    order = one.order
    limits = "" if order is None else f"{order.meaning}, {order.lowest} to {order.highest}; by default {order.default}"
    refined = "yes" if one.refined else "no"
    cells = (f"`{one.name}`", one.description, one.grid, limits, ", ".join(one.brings), refined, one.source)
    return f"| {' | '.join(cells)} |"


def format_table() -> str:
    """The formats there are, a row each."""
    rows = ["| name | what it is | endings | holds | read, written | may need |", "|---|---|---|---|---|---|"]
    for one in all_formats():
        does = ", ".join(word for word, there in (("read", one.read), ("written", one.write)) if there)
        options = (OPTIONS.get(option, option).removesuffix("_hz").replace("_", "-") for option in one.asks)
        asks = ", ".join(f"`--{option}`" for option in options)
        endings = ", ".join(f"`{ending}`" for ending in one.endings)
        rows.append(f"| `{one.name}` | {one.description} | {endings} | {', '.join(one.holds)} | {does} | {asks} |")
    return "\n".join(rows)


def _between(page: Path, table: str) -> str:
    text = page.read_text(encoding="utf-8")
    head, _, rest = text.partition("<!-- table -->\n")
    _, _, tail = rest.partition("<!-- end -->\n")
    return f"{head}<!-- table -->\n{table}\n<!-- end -->\n{tail}"


def _choices(text: str, command: str, option: str, names: tuple[str, ...]) -> str:
    before, heading, rest = text.partition(f"## `{command}`\n")
    listed = f"`{option} {{{','.join(names)}}}`"
    return before + heading + re.sub(rf"`{option} \{{[^}}]*\}}`", lambda _: listed, rest, count=1)


if __name__ == "__main__":
    for path, content in pages().items():
        path.write_text(content, encoding="utf-8", newline="\n")
