"""Reads a report as a browser would, as far as the tests look."""

from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "br", "hr", "input", "img", "link"}


@dataclass
class Table:
    caption: str = ""
    rows: list[list[str]] = field(default_factory=list)
    scopes: list[str] = field(default_factory=list)


class Page(HTMLParser):
    """Tags, attributes, tables and text of a page; rejects a page whose tags don't match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.tables: list[Table] = []
        self.sections: dict[str, str] = {}
        self.text = ""
        self._section = ""
        self._cell: list[str] | None = None
        self.feed(text)
        self.close()
        assert not self.open, f"left open: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, {k: v or "" for k, v in attrs}))
        if tag in VOID:
            return
        self.open.append(tag)
        if tag == "section":
            self._section = dict(attrs)["id"]
            self.sections[self._section] = ""
        elif tag == "table":
            self.tables.append(Table())
        elif tag == "tr":
            self.tables[-1].rows.append([])
        elif tag in ("th", "td", "caption"):
            self._cell = []
            if tag == "th":
                self.tables[-1].scopes.append(dict(attrs).get("scope", ""))

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, {k: v or "" for k, v in attrs}))

    def handle_endtag(self, tag):
        assert self.open
        assert self.open.pop() == tag
        if tag in ("th", "td"):
            self.tables[-1].rows[-1].append("".join(self._cell or []))
            self._cell = None
        elif tag == "caption":
            self.tables[-1].caption = "".join(self._cell or [])
            self._cell = None
        elif tag == "section":
            self._section = ""

    def handle_data(self, data):
        if self.open and self.open[-1] in ("style", "script"):
            return
        text = data.replace("\u00a0", " ")
        self.text += text
        if self._cell is not None:
            self._cell.append(text)
        if self._section:
            self.sections[self._section] += text

    def table(self, caption: str) -> Table:
        return next(t for t in self.tables if caption in t.caption)

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for name, attributes in self.tags if name == tag]
