"""Many errors in one message: a user mends a list at once, not one entry a run."""

from types import TracebackType

from modallab.core.errors import ModallabError

_MOST = 20


class ErrorCollection:
    """Keeps the expected errors raised under it: `with errors: ...` any number of times, then `errors.done()`."""

    def __init__(self) -> None:
        self.errors: list[ModallabError] = []

    def __enter__(self) -> None:
        return

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        if isinstance(error, ModallabError):
            self.errors.append(error)
            return True
        return False

    def done(self) -> None:
        """Raise what was kept: the error itself if there is one, else one of the first one's type that lists all."""
        if not self.errors:
            return
        if len(self.errors) == 1:
            raise self.errors[0]
        lines = [f"{e.where}: {e.what}" if e.where else e.what for e in self.errors[:_MOST]]
        if len(self.errors) > _MOST:
            lines.append(f"... and {len(self.errors) - _MOST} more")
        remedies = dict.fromkeys(e.remedy for e in self.errors if e.remedy)
        raise type(self.errors[0])(
            f"{len(self.errors)} problems:\n  " + "\n  ".join(lines), remedy="; ".join(remedies)
        ) from self.errors[0]
