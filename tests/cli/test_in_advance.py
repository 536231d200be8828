"""What a command computes while its bench is still at work."""

import threading

import pytest

from modallab.cli.demo import BackgroundResult


def test_it_is_computed_while_the_caller_goes_on() -> None:
    go_on = threading.Event()
    computed = BackgroundResult(lambda: go_on.wait(10.0))
    go_on.set()
    assert computed.result() is True


def test_what_it_raised_is_raised_where_the_result_is_asked_for() -> None:
    computed = BackgroundResult(lambda: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        computed.result()


def test_nobody_who_leaves_waits_for_it() -> None:
    before = set(threading.enumerate())
    stop = threading.Event()
    BackgroundResult(stop.wait)
    (own,) = set(threading.enumerate()) - before
    assert own.daemon
    stop.set()
