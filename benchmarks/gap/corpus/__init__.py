"""Campaigns whose truth is known, on which any engine of the diagnosis is scored."""

import os

# One thread of linear algebra, before anything imports NumPy: seconds are those of one processor.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
