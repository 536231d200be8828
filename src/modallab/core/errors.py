"""The errors a user can meet. Each says what was wrong, with the value, and what to do about it."""

from typing import ClassVar


class ModallabError(Exception):
    """Root of all expected errors.

    Args:
        what: what was wrong, with the value that was found.
        remedy: what the user can do about it.
        where: the file, channel or field concerned.
    """

    code: ClassVar[str] = "error"
    exit_code: ClassVar[int] = 2

    def __init__(self, what: str, *, remedy: str = "", where: str = "") -> None:
        self.what = what
        self.remedy = remedy
        self.where = where
        super().__init__(what, remedy, where)

    def __str__(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        return f"{head}\n  what to do: {self.remedy}" if self.remedy else head

    def __reduce__(self) -> tuple[object, ...]:
        # Errors cross from the acquisition process to its parent; keyword arguments must survive pickling.
        return (_rebuild, (type(self), self.what, self.remedy, self.where))


def _rebuild(kind: type[ModallabError], what: str, remedy: str, where: str) -> ModallabError:
    return kind(what, remedy=remedy, where=where)


class RigError(ModallabError):
    """The rig file is not valid, or lacks what this step needs."""

    code = "rig"


class PlanError(ModallabError):
    """The plan asks for something the rig, its limits or the bench cannot do."""

    code = "plan"


class FormatError(ModallabError):
    """A file cannot be read as what it claims to be: cut off, foreign, of an unknown version."""

    code = "format"


class DataError(ModallabError):
    """A recording holds what no measurement can hold: NaN, a dead channel, a wrong shape or unit."""

    code = "data"


class IdentificationError(ModallabError):
    """The data do not carry the modal model that was asked of them."""

    code = "identification"


class BenchError(ModallabError):
    """A device of the bench failed, is absent, or rejected what was asked."""

    code = "bench"


class ConfigurationError(BenchError):
    """The device cannot be configured as asked. Never retried."""

    code = "bench-configuration"


class DeviceGoneError(BenchError):
    """The device is gone: unplugged, powered off, or its server is."""

    code = "bench-gone"


class DeviceBusyError(BenchError):
    """Another owner holds the device."""

    code = "bench-busy"


class SamplesLostError(BenchError):
    """The device lost samples. What follows is a new stretch, never spliced to the old."""

    code = "bench-samples-lost"


class BenchTimeoutError(BenchError):
    """No samples arrived in time. What had arrived is kept."""

    code = "bench-timeout"


class OutputLostError(BenchError):
    """The device could not keep its output going; the output was brought to 0 V."""

    code = "bench-output"


class UnsupportedError(BenchError):
    """The device cannot do this at all, such as an output on a replayed campaign."""

    code = "bench-unsupported"


class SafetyError(ModallabError):
    """A limit of the rig was or would have been exceeded; the output is at zero."""

    code = "safety"


class StorageError(ModallabError):
    """A recording could not be kept or read back. What was acknowledged before is untouched."""

    code = "storage"


class DiskFullError(StorageError):
    """The disk is full."""

    code = "disk_full"


class JobError(ModallabError):
    """A job cannot be ordered or computed as asked."""

    code = "job"


class UnknownJobError(JobError):
    """There is no job of this name."""

    code = "job-unknown"
