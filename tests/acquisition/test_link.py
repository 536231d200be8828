"""The rig process's end of the pipe: orders, time-out, a broken pipe."""

import multiprocessing
import time

from modallab.acquisition.process.owner_link import (
    AbortRun,
    CloseOrder,
    OwnerHeartbeat,
    OwnerLink,
    RunEnded,
    RunPlan,
    StopRun,
)
from modallab.acquisition.process.prepare_run import Order
from modallab.core.plan import ImpactPlan


def waited_for(link: OwnerLink, order: Order, within_s: float = 5.0) -> bool:
    end = time.monotonic() + within_s
    while link.next_order() != order and time.monotonic() < end:
        time.sleep(0.01)
    return link.next_order() == order


def test_orders_come_through_and_a_new_run_forgets_the_last_ones() -> None:
    mine, theirs = multiprocessing.Pipe()
    link = OwnerLink(theirs)
    mine.send(AbortRun())
    assert waited_for(link, "abort")
    mine.send(RunPlan(ImpactPlan(points=(1,))))
    assert link.next_plan() is not None
    assert link.next_order() is None
    mine.send(StopRun())
    assert waited_for(link, "stop")
    mine.send(CloseOrder())
    assert link.next_plan() is None
    mine.close()


def test_a_broken_pipe_is_a_lost_owner() -> None:
    mine, theirs = multiprocessing.Pipe()
    link = OwnerLink(theirs)
    mine.close()
    assert waited_for(link, "lost")
    assert link.next_plan() is None


def test_a_time_out_is_a_lost_owner_and_a_heartbeat_prevents_it() -> None:
    mine, theirs = multiprocessing.Pipe()
    link = OwnerLink(theirs, timeout_s=0.5)
    for _ in range(8):
        mine.send(OwnerHeartbeat())
        time.sleep(0.1)
    assert link.next_order() is None
    assert waited_for(link, "lost")
    mine.close()


def test_reports_never_wait_for_an_owner_that_does_not_listen() -> None:
    mine, theirs = multiprocessing.Pipe()
    link = OwnerLink(theirs)
    begin, began = time.monotonic(), time.thread_time()
    for _ in range(20000):
        link.send(RunEnded(None))
    assert time.thread_time() - began < 2.0
    # The shortest wait of a system, a millisecond, for each would be twice that; a busy machine takes a part of it.
    assert time.monotonic() - begin < 10.0
    assert mine.recv() == RunEnded(None)
    mine.close()
