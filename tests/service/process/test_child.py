"""A process of the service that is asked to leave while it is started, or before."""

import multiprocessing
from threading import Thread

from modallab.service.process.child_processes import SupervisedProcess

SLEEP = "sleeping_child:sleep"


def test_one_that_was_asked_to_leave_is_never_started() -> None:
    child = SupervisedProcess("late", SLEEP, (60.0,))
    child.request_exit()
    child.check_now()
    child.close()
    assert child.process is None


def test_one_that_is_asked_to_leave_while_it_is_started_is_gone_when_it_is_closed() -> None:
    child = SupervisedProcess("early", SLEEP, (60.0,))
    for _ in range(3):
        starting = Thread(target=child.check_now)
        starting.start()
        child.request_exit()
        child.close()
        starting.join()
        # Of this name only: other tests of the same worker keep rigs of their own.
        assert child.name not in {one.name for one in multiprocessing.active_children()}
