"""What a thread computes while this one waits for something else."""

from collections.abc import Callable
from concurrent.futures import Future
from threading import Thread
from typing import Generic, TypeVar

Result = TypeVar("Result")


class BackgroundResult(Generic[Result]):
    """A result that is being computed. Who stops the program does not wait for it."""

    def __init__(self, compute: Callable[[], Result]) -> None:
        self._future: Future[Result] = Future()
        # A pool would have the program wait at its end.
        Thread(target=self._run, args=(compute,), daemon=True).start()

    def result(self) -> Result:
        """The result, once it is there. Raises whatever the computation raised."""
        return self._future.result()

    def _run(self, compute: Callable[[], Result]) -> None:
        try:
            self._future.set_result(compute())
        except BaseException as error:
            self._future.set_exception(error)
