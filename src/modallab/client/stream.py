"""Server-sent events, read line by line."""

from collections.abc import Iterable, Iterator

from modallab.core.documents.pages import EventView


def read_events(lines: Iterable[str]) -> Iterator[EventView]:
    """The events in a stream of lines (WHATWG HTML, 9.2.6)."""
    data: list[str] = []
    for line in lines:
        if not line:
            if data:
                yield EventView.model_validate_json("\n".join(data))
            data = []
        elif line.startswith("data:"):
            data.append(line[5:].removeprefix(" "))
