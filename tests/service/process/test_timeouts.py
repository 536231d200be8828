"""A frozen process is found out within a second; one that only has to wait its turn is not."""

import threading
import time
from multiprocessing import Pipe

import pytest

from modallab.service.process.child_processes import HeartbeatTimer
from modallab.service.process.process_messages import CallServer, ProcessHeartbeat, RemoteControl

LOOK_S = 0.05


class Clock:
    """Goes on when it is made to."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


def _until_found(timer: HeartbeatTimer, clock: Clock, look_s: float) -> float:
    began = clock.now_s
    while not timer.check_now(began, 0.0):
        clock.now_s += look_s
        assert clock.now_s < began + 60
    return clock.now_s - began


def test_on_an_idle_machine_a_second_is_a_second(clock: Clock) -> None:
    assert _until_found(HeartbeatTimer(1.0, LOOK_S, clock), clock, LOOK_S) == pytest.approx(1.05, abs=0.06)


def test_whoever_listens_late_himself_does_not_blame_the_other(clock: Clock) -> None:
    timer = HeartbeatTimer(1.0, LOOK_S, clock)
    received_s = clock.now_s
    # One look in which nobody had the processor for two seconds, then a sign.
    assert not timer.check_now(received_s, 0.0)
    clock.now_s += 2.0
    assert not timer.check_now(received_s, 0.0)
    assert not timer.check_now(clock.now_s, 0.0)
    assert timer.counted_s == 0.0


def test_however_busy_five_times_the_time_out_is_too_long(clock: Clock) -> None:
    assert _until_found(HeartbeatTimer(1.0, LOOK_S, clock), clock, 0.7) == pytest.approx(5.2, abs=0.71)


def test_a_process_that_works_is_given_more_time_and_not_for_ever(clock: Clock) -> None:
    timer = HeartbeatTimer(1.0, LOOK_S, clock)
    received_s, used_s = clock.now_s, 0.0
    while not timer.check_now(received_s, used_s):
        clock.now_s += LOOK_S
        used_s += 0.01
        assert clock.now_s < received_s + 60
    assert clock.now_s - received_s == pytest.approx(5.05, abs=0.06)


def test_every_sign_begins_anew(clock: Clock) -> None:
    timer = HeartbeatTimer(1.0, LOOK_S, clock)
    for _ in range(40):
        received_s = clock.now_s
        for _ in range(15):
            clock.now_s += LOOK_S
            assert not timer.check_now(received_s, 0.0)


def test_new_events_wait_for_nobody_who_reads_no_more() -> None:
    ours, theirs = Pipe()
    counter = CallServer(ours, control=None)
    try:
        theirs.send(ProcessHeartbeat())
        while not counter.began:
            time.sleep(0.01)
        # Much more than a pipe holds, and nobody reads any of it.
        saying = threading.Thread(target=lambda: [counter.new_events() for _ in range(100_000)], daemon=True)
        saying.start()
        saying.join(30)
        assert not saying.is_alive()
    finally:
        theirs.close()


def test_who_reads_hears_of_new_events() -> None:
    ours, theirs = Pipe()
    gone, received_s = threading.Event(), threading.Event()
    remote = RemoteControl(theirs, gone.set)
    remote.on_events = received_s.set
    counter = CallServer(ours, control=None)
    while not counter.began:
        time.sleep(0.01)
    for _ in range(20):
        received_s.clear()
        counter.new_events()
        assert received_s.wait(10)
    ours.send(None)
    assert gone.wait(10)
