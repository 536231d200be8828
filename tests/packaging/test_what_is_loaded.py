"""A process loads what its work needs: what a test bench and an order need is there before SciPy would be."""

import subprocess
import sys

RECORDING = (
    "modallab.acquisition.process.child",
    "modallab.notebook.record",
    "modallab.notebook.simulate",
    "modallab.service.campaigns.local_session",
    "modallab.service.jobs.campaign_jobs",
)
COMPUTING = ("modallab.gap.diagnosis", "modallab.pipelines.identify", "modallab.pipelines.job_kinds")
PROGRAM = f"""
import sys
from importlib import import_module

def loaded(names, unwanted):
    for name in names:
        import_module(name)
        for one in unwanted:
            if one in sys.modules:
                print(name, "loads", one)

loaded({RECORDING}, ["scipy", "matplotlib", "modallab.pipelines.identify"])
loaded({COMPUTING}, ["scipy.signal", "scipy.stats", "matplotlib"])
"""


def test_who_records_or_orders_loads_no_scipy_and_who_computes_only_parts_of_it() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stdout == ""
