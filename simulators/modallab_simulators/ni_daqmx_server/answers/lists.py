"""Lists as the wire carries them."""

from collections.abc import Iterable


def comma_list(names: Iterable[str]) -> str:
    """Names with commas between them."""
    return ", ".join(names)
