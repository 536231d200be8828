"""The errors a user can meet. Each says what was wrong, with the value, and what to do about it."""

from types import TracebackType
from typing import ClassVar, NamedTuple

_MOST = 20


class HttpProblem(NamedTuple):
    """How the service answers with an error: a kind of problem, with a page of its own.

    Attributes:
        status: HTTP status.
        title: in a few words.
        meaning: what it says and what to do.
    """

    status: int
    title: str
    meaning: str


_TO_DO = "\n  what to do: "
"""Between what was wrong and the remedy, where an error is written as text."""


class ModallabError(Exception):
    """Base class of all expected errors.

    Args:
        what: what was wrong, with the value that was found.
        remedy: what the user can do about it.
        where: the file, channel or field concerned.

    A class that declares no `http` is answered as the nearest class above it that does.
    """

    code: ClassVar[str] = "error"
    http: ClassVar[HttpProblem] = HttpProblem(500, "Not done", "Read the message.")
    exit_code: ClassVar[int] = 2

    def __init__(self, what: str, *, remedy: str = "", where: str = "") -> None:
        self.what = what
        self.remedy = remedy
        self.where = where
        super().__init__(what, remedy, where)

    def __str__(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        return f"{head}{_TO_DO}{self.remedy}" if self.remedy else head

    def __reduce__(self) -> tuple[object, ...]:
        # Errors cross from the acquisition process to its parent; keyword arguments must survive pickling.
        return (_rebuild, (type(self), self.what, self.remedy, self.where))


def split_remedy(text: str) -> tuple[str, str]:
    """What was wrong and the remedy, of the text of an error; the remedy is "" where it has none."""
    what, _, remedy = text.partition(_TO_DO)
    return what, remedy


def _rebuild(kind: type[ModallabError], what: str, remedy: str, where: str) -> ModallabError:
    return kind(what, remedy=remedy, where=where)


class MissingPackageError(ModallabError):
    """A package that only some work needs is not installed; the remedy says how to install it."""

    code = "package"
    http = HttpProblem(501, "A package is missing", "Install the package on the service's machine, as the answer says.")


class RigError(ModallabError):
    """The rig file is not valid, or lacks what this step needs."""

    code = "rig"
    http = HttpProblem(422, "The rig lacks something", "Complete the rig file.")


class PlanError(ModallabError):
    """The rig, its limits or the bench do not allow the plan."""

    code = "plan"
    http = HttpProblem(
        422,
        "The plan is not possible",
        "The rig, its limits or the bench do not allow the plan; every reason is named.",
    )


class FormatError(ModallabError):
    """A file cannot be read: it is truncated, foreign, or of an unknown version."""

    code = "format"
    http = HttpProblem(422, "A file cannot be read", "The file is truncated, foreign, or of an unknown version.")


class DataError(ModallabError):
    """A recording contains impossible values: NaN, a dead channel, a wrong shape or unit."""

    code = "data"
    http = HttpProblem(
        422, "The data cannot be used", "The data contain impossible values, or lack what was requested."
    )


class IdentificationError(ModallabError):
    """The requested modal model cannot be identified from these data."""

    code = "identification"
    http = HttpProblem(422, "No model in these data", "Look at the FRF and its coherence.")


class BenchError(ModallabError):
    """A device of the bench failed, is absent, or rejected a command."""

    code = "bench"
    http = HttpProblem(503, "The bench failed", "A device failed, is absent, or rejected a command.")


class ConfigurationError(BenchError):
    """The device cannot be configured as asked. Never retried."""

    code = "bench-configuration"


class DeviceGoneError(BenchError):
    """The device is unplugged or powered off, or its server has ended."""

    code = "bench-gone"


class DeviceBusyError(BenchError):
    """Another owner holds the device."""

    code = "bench-busy"
    http = HttpProblem(409, "The device is held by another", "Close the other program.")


class SamplesLostError(BenchError):
    """The device lost samples. Later samples are never joined to earlier ones."""

    code = "bench-samples-lost"


class BenchTimeoutError(BenchError):
    """No samples arrived in time. Earlier samples are kept."""

    code = "bench-timeout"


class OutputLostError(BenchError):
    """The device interrupted its output; the output was brought to 0 V."""

    code = "bench-output"


class UnsupportedError(BenchError):
    """The device cannot do this at all, such as an output on a replayed campaign."""

    code = "bench-unsupported"


class SafetyError(ModallabError):
    """A limit of the rig was or would have been exceeded; the output is at zero."""

    code = "safety"
    http = HttpProblem(
        409, "Beyond a limit", "A limit of the rig was or would have been exceeded; the output is at 0 V."
    )


class StorageError(ModallabError):
    """A recording could not be stored or read. Acknowledged blocks are kept."""

    code = "storage"
    http = HttpProblem(
        500, "The data folder cannot be read or written", "Check the disk; acknowledged blocks are kept."
    )


class DiskFullError(StorageError):
    """The disk is full."""

    code = "disk_full"
    http = HttpProblem(507, "The disk is full", "Free space on the disk; acknowledged blocks are kept.")


class DatabaseLostError(StorageError):
    """The database server cannot be reached, or ended the connection."""

    code = "database-lost"
    http = HttpProblem(
        503,
        "The database cannot be reached",
        "Check the database server; the service continues when the server is back.",
    )


class RowDamagedError(StorageError):
    """A row of the database is damaged."""

    code = "row-damaged"
    http = HttpProblem(500, "A row of the database is damaged", "Restore the database from a backup.")


class BlockDamagedError(StorageError):
    """The samples of a block on the disk differ from those recorded."""

    code = "block-damaged"
    http = HttpProblem(
        500,
        "A block is damaged",
        "The samples on the disk differ from those recorded. Restore the run's file from a backup, or reject the "
        "block.",
    )


class JobError(ModallabError):
    """A job cannot be ordered or computed as asked."""

    code = "job"
    http = HttpProblem(422, "The job cannot be ordered", "Look at its parameters.")


class UnknownJobError(JobError):
    """There is no job of this name."""

    code = "job-unknown"
    http = HttpProblem(404, "There is no such job", "Look at the list of jobs.")


class ErrorCollection:
    """Keeps the expected errors raised under it: `with errors: ...` any number of times, then `errors.done()`.

    A user mends a list at once, not one entry a run.
    """

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

    def raise_collected(self) -> None:
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
