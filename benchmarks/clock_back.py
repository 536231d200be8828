"""The clock on the wall is set back an hour in the middle of a run: nothing may change.

A small library, compiled here, stands between the service's processes and the operating system and takes an hour off
every time of day from the moment a file appears; the monotonic clock stays as it is. Linux with a C compiler.

    python benchmarks/clock_back.py
"""

import subprocess
import sys
import tempfile
from datetime import datetime
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from kept import Follower, require_kept
from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan

SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static long back(void) { const char *f = getenv("CLOCK_BACK"); return f && access(f, F_OK) == 0 ? 3600 : 0; }
int clock_gettime(clockid_t id, struct timespec *t) {
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    int r = real(id, t);
    if (id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE) t->tv_sec -= back();
    return r;
}
int gettimeofday(struct timeval *t, void *z) {
    struct timespec s; int r = clock_gettime(CLOCK_REALTIME, &s); (void)z;
    t->tv_sec = s.tv_sec; t->tv_usec = s.tv_nsec / 1000; return r;
}
time_t time(time_t *t) {
    struct timespec s; clock_gettime(CLOCK_REALTIME, &s); if (t) *t = s.tv_sec; return s.tv_sec;
}
"""


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "shim.c").write_text(SHIM, encoding="utf-8")
        command = ["cc", "-shared", "-fPIC", "-O1", "-o", str(folder / "shim.so"), str(folder / "shim.c"), "-ldl"]
        subprocess.run(command, check=True)
        mark = folder / "back"
        env = {"LD_PRELOAD": str(folder / "shim.so"), "CLOCK_BACK": str(mark)}
        bench = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
        with ServiceProcess(folder / "data", "--workers", "1", bench=bench, env=env) as service:
            lab = service.client
            follower = Follower(service.url, service.token)
            campaign = lab.create_campaign("clock", service.rig)
            with lab.take_lease(service.rig, "Ada", ttl_s=300) as lease:
                run = lab.start_run(campaign.id, ImpactPlan(points=(10, 6, 3), hits=10), lease).id
                for event in lab.follow_run(run):
                    if event.kind == "block" and event.content["n"] == 5:
                        mark.touch()
            view = lab.run(run)
            assert (view.state, view.accepted) == ("done", 30), view
            utc = [datetime.fromisoformat(block.utc) for block in lab.blocks(run)]
            assert (utc[0] - utc[-1]).total_seconds() > 3000, "the clock was not set back"
            (job,) = lab.jobs(campaign.id, "identify")
            assert lab.wait_for_job(job.id, 3600.0).state == "done"
            require_kept(lab, follower.acknowledged)
            seqs = [event.seq for event in follower.events]
            assert seqs == list(range(1, len(seqs) + 1))
    print(f"clock set back an hour after block 5 of 30: run done, {len(view.plan.points)} points, model identified,")
    print(f"{len(follower.acknowledged)} acknowledged blocks all there, {len(seqs)} events in one order")
    return 0


if __name__ == "__main__":
    sys.exit(main())
