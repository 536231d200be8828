"""A runner in a process of its own, to be killed: python runner_process.py DATABASE SCHEDULER FOLDER LEASE."""

import sys
import time
from pathlib import Path

from kinds_for_tests import kinds

from modallab.jobs import Jobs
from modallab.jobs.runner import JobRunner
from modallab.storage.engine import open_engine

if __name__ == "__main__":
    database, scheduler, folder, lease = sys.argv[1:]
    with JobRunner(Jobs(open_engine(database)), kinds(Path(folder)), scheduler, lease_s=float(lease)):
        time.sleep(120)
