"""What the system says about a process that asked to come first is what the process was told."""

import subprocess
import sys

ASK = """
import os, sys
from modallab.acquisition.urgency import come_first

def rank():
    if sys.platform == "win32":
        import ctypes
        kernel = ctypes.windll.kernel32
        kernel.GetCurrentProcess.restype = ctypes.c_void_p
        return kernel.GetPriorityClass(ctypes.c_void_p(kernel.GetCurrentProcess()))
    policy = os.sched_getscheduler(0) if hasattr(os, "sched_getscheduler") else 0
    return policy, -os.getpriority(os.PRIO_PROCESS, 0)

before = rank()
print(come_first(), rank() > before, rank() == before)
"""


def test_it_is_raised_if_and_only_if_it_says_so() -> None:
    said = subprocess.run([sys.executable, "-c", ASK], capture_output=True, text=True, check=True).stdout.split()
    assert said in (["True", "True", "False"], ["False", "False", "True"])
