"""What a machine sees of how pages and names read: long sentences, class names in two files, decisions nobody needs.

`check_words.py` runs it. What was there before the check stands in `allowed.toml`, as numbers and lists that may only
shrink: `python docs/reference/check_words.py --lower` writes what is left.
"""

import re
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

MOST_WORDS = 25
ALLOWED = "docs/reference/allowed.toml"
SOURCES = ("src", "drivers", "simulators")

_FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_CODE = re.compile(r"`[^`]*`")
_TARGET = re.compile(r"\]\([^)]*\)")
_NEW_BLOCK = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*] |[|#>]|\d+\. ))")
_CELL = re.compile(r"(?<!\\)\|")
_END = re.compile(r"(?<=[.!?:])[)*\"]*\s+")
_WORD = re.compile(r"\w*[^\W\d_][\w'-]*")
_CLASS = re.compile(r"^class ([A-Z]\w*)", re.MULTILINE)
_DECISION = re.compile(r"decisions/(\d{4}-[a-z0-9-]+\.md)")


def sentences(text: str) -> Iterator[str]:
    """The sentences of a page: of paragraphs, list items and cells of tables, not of headings or fenced blocks.

    A colon ends a sentence too. A piece of code is one word, a link its text.
    """
    text = _FENCED.sub("", _COMMENT.sub("", text))
    text = _TARGET.sub("]", _CODE.sub("code", text))
    for block in _NEW_BLOCK.split(text):
        if block.lstrip().startswith("#"):
            continue
        for cell in _CELL.split(block) if block.lstrip().startswith("|") else [block]:
            yield from _END.split(" ".join(cell.split()))


def long_sentences(text: str) -> list[str]:
    """The sentences of a page with more than 25 words; a number is no word."""
    return [sentence for sentence in sentences(text) if len(_WORD.findall(sentence)) > MOST_WORDS]


def shared_names(texts: dict[str, str]) -> list[str]:
    """Names of public classes that stand in two files or more, given the text of each file."""
    places = Counter(name for text in texts.values() for name in set(_CLASS.findall(text)))
    return sorted(name for name, files in places.items() if files > 1)


def unneeded_decisions(decisions: Iterable[str], texts: Iterable[str]) -> list[str]:
    """Decisions that none of the texts refers to."""
    referred = {page for text in texts for page in _DECISION.findall(text)}
    return sorted(set(decisions) - referred)


def problems(root: Path) -> list[str]:
    """What is wrong in the project, beyond what is allowed."""
    allowed = tomllib.loads((root / ALLOWED).read_text(encoding="utf-8"))
    found, pages = _long_by_page(root), allowed["long_sentences"]
    wrong = [
        f"{page}: {len(long)} sentences of more than {MOST_WORDS} words, {pages.get(page, 0)} allowed; "
        f'the first: "{long[0][:100]} ..." -> make two of it'
        for page, long in found.items()
        if len(long) > pages.get(page, 0)
    ]
    new = set(shared_names(_sources(root))) - set(allowed["shared_names"])
    wrong += [f"class {name}: stands in two files -> one name for one class" for name in sorted(new)]
    decisions, texts = _decisions(root)
    wrong += [
        f"docs/decisions/{page}: no page or source refers to it -> refer to it, or delete it"
        for page in unneeded_decisions(decisions, texts)
    ]
    return wrong


def lower(root: Path) -> None:
    """Write what is left of what is allowed; nothing rises."""
    file = root / ALLOWED
    text = file.read_text(encoding="utf-8")
    allowed = tomllib.loads(text)
    found = _long_by_page(root)
    counts = {page: min(most, len(found.get(page, []))) for page, most in allowed["long_sentences"].items()}
    names = sorted(set(allowed["shared_names"]) & set(shared_names(_sources(root))))
    lines = [line for line in text.splitlines() if line.startswith("#")]
    lines += ["shared_names = [", *(f'  "{name}",' for name in names), "]", "", "[long_sentences]"]
    lines += [f'"{page}" = {count}' for page, count in sorted(counts.items()) if count]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _long_by_page(root: Path) -> dict[str, list[str]]:
    by_page: dict[str, list[str]] = defaultdict(list)
    for file in [root / "README.md", root / "CHANGELOG.md", *sorted((root / "docs").rglob("*.md"))]:
        if long := long_sentences(file.read_text(encoding="utf-8")):
            by_page[file.relative_to(root).as_posix()] = long
    return by_page


def _sources(root: Path) -> dict[str, str]:
    files = [file for start in SOURCES for file in (root / start).rglob("*.py")]
    return {str(file): file.read_text(encoding="utf-8") for file in files}


def _decisions(root: Path) -> tuple[list[str], list[str]]:
    folder = root / "docs" / "decisions"
    pages = [file for file in (root / "docs").rglob("*") if file.suffix in {".md", ".ipynb"} and file.parent != folder]
    pages += [root / "README.md", root / "CHANGELOG.md"]
    texts = [file.read_text(encoding="utf-8") for file in pages]
    return [file.name for file in folder.glob("[0-9]*.md")], [*texts, *_sources(root).values()]
