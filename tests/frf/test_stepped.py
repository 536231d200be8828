import modal_bench as bench
import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.frf.stepped import stepped_frf
from modallab.signals.faults.whole_channels import overloaded_channels
from modallab.signals.signals import to_signals_of

TRUE = np.array([0.5 - 2j, 1.5 + 0.1j])


def sines(frequencies, levels=(1.0,)):
    rng = np.random.default_rng(2)
    t = np.arange(1024) / 1000.0
    blocks = []
    for level in levels:
        for f in frequencies:
            turn = level * np.exp(2j * np.pi * (f * t + 0.1))
            samples = np.real(np.array([1.0, *TRUE])[:, None] * turn) + 1e-6 * rng.standard_normal((3, 1024))
            blocks.append(bench.block(f"{level}_{f}", "sine", len(blocks), 1000.0, samples, 2, frequency_hz=f))
    return blocks


def test_one_line_a_frequency_by_rising_frequency_and_levels_averaged():
    rig = bench.rig(2)
    signals = to_signals_of(sines([30.2, 11.7], levels=(1.0, 0.25)), rig)
    frf = stepped_frf(signals, rig)
    np.testing.assert_allclose(frf.frequency_hz, [11.7, 30.2])
    np.testing.assert_allclose(frf.values[:, 0], np.stack([TRUE, TRUE], axis=1), rtol=1e-5)
    assert frf.quantity == "inertance"
    assert frf.input_points == (2,)
    assert frf.averages == (2,)


def test_no_blocks_are_rejected():
    with pytest.raises(DataError, match="no block"):
        stepped_frf([], bench.rig(2))


@pytest.mark.parametrize(("peak", "found"), [(32767, ("a01",)), (-32768, ("a01",)), (32000, ())])
def test_counts_at_the_types_end_are_an_overload(peak, found):
    samples = np.zeros((3, 64), dtype=np.int16)
    samples[1, 7] = peak
    assert overloaded_channels(bench.block("r", "impact", 0, 1000.0, samples, 1), bench.rig(2)) == found


def test_engineering_units_have_no_full_scale():
    samples = np.zeros((3, 64))
    samples[1, 7] = 1e9
    assert overloaded_channels(bench.block("r", "impact", 0, 1000.0, samples, 1), bench.rig(2)) == ()
