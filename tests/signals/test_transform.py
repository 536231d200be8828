"""Transforms and quick lengths are SciPy's, without SciPy where a record is short."""

import subprocess
import sys

import numpy as np
import pytest
import scipy.fft

from modallab.core.errors import DataError
from modallab.signals.transform import SHORT, next_quick_length, previous_quick_length, spectrum


def test_quick_lengths_are_scipys() -> None:
    for n in (*range(1, 300), 1021, 4096, 4097, 65537, 999983):
        assert next_quick_length(n) == scipy.fft.next_fast_len(n, real=True)
        assert previous_quick_length(n) == scipy.fft.prev_fast_len(n, real=True)


@pytest.mark.parametrize("n", [0, -4])
def test_a_length_without_samples_is_rejected(n: int) -> None:
    for of in (next_quick_length, previous_quick_length):
        with pytest.raises(DataError, match=f"transform of {n} samples"):
            of(n)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("n", [None, 1500, SHORT + 1])
def test_a_spectrum_keeps_the_records_precision(kind: type, n: int | None) -> None:
    record = np.random.default_rng(1).normal(size=2048).astype(kind)
    lines = spectrum(record, n)
    assert lines.dtype == np.result_type(kind, np.complex64)
    np.testing.assert_allclose(lines, scipy.fft.rfft(record.astype(float), n), atol=1000 * np.finfo(kind).eps)


def test_a_bench_begins_without_scipy() -> None:
    code = (
        "import sys, modallab.acquisition.process.child as c, modallab_simulators.cantilever as s;"
        "print([name for name in sys.modules if name.startswith('scipy')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
