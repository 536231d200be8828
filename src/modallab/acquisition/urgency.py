"""Asks the system to run this process before others: what ends an excitation must not wait for a busy machine."""

import os
import sys

NICE = -10
LOWEST_REAL_TIME = 1


def come_first() -> bool:
    """Raise this process's priority as far as it is allowed; threads that begin later have it too.

    Only for what waits nearly all of the time. On Windows the priority class "high", which needs no rights. On Linux
    the lowest real-time priority, which waits for no ordinary process, or else a lower nice value; both need a right
    (`RLIMIT_RTPRIO` or `RLIMIT_NICE`).

    Returns:
        Whether the system allowed any of it.
    """
    return any(way() for way in (_high_class, _real_time, _nice))


def _high_class() -> bool:
    if sys.platform != "win32":
        return False
    import ctypes

    kernel = ctypes.windll.kernel32
    kernel.GetCurrentProcess.restype = ctypes.c_void_p
    high_priority_class = 0x80
    return bool(kernel.SetPriorityClass(ctypes.c_void_p(kernel.GetCurrentProcess()), high_priority_class))


def _real_time() -> bool:
    if sys.platform != "linux":
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(LOWEST_REAL_TIME))
    except OSError:
        return False
    return True


def _nice() -> bool:
    if sys.platform == "win32":
        return False
    try:
        os.nice(NICE)
    except OSError:
        return False
    return True
