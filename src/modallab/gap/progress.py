"""What a diagnosis is at while it computes, for who waits for it."""

from collections.abc import Callable

Notify = Callable[[float, str], None]
"""Called with a share from 0 to 1 that never falls, and with what is computed now."""

FURTHER = 0.93
"""What a step leaves of the rest: how many steps there will be depends on what they find."""


class Steps:
    """Counts the steps of a diagnosis and reports each."""

    def __init__(self, notify: Notify | None = None) -> None:
        """Report to `notify`, or to nobody."""
        self._notify, self._left = notify, 1.0

    def __call__(self, words: str) -> None:
        """The next step begins."""
        if self._notify is not None:
            self._notify(1 - self._left, words)
        self._left *= FURTHER
