"""FRFs of several set-ups, as analysers give them: joined by the sensor that stays, against closed-form modes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.setups import identify_setups, setup_names

LINES = np.arange(5.0, 205.0, 0.25)
MODES = ((40.0, 0.010, (0.7, 0.45, -0.3, 0.5)), (130.0, 0.008, (0.5, -0.8, 0.6, 0.2)))
"""Frequency in Hz, damping ratio, and shape at points 1 to 4 in 1/sqrt(kg)."""


def rig(roving: int) -> Rig:
    channels = (
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="stays", quantity="acceleration", unit="m/s^2", point=1),
        Channel(index=2, name="roves", quantity="acceleration", unit="m/s^2", point=roving),
    )
    points = tuple(Point(id=k, x_m=0.1 * k) for k in (1, 2, 3, 4))
    return Rig(name="plate", model="unknown", points=points, channels=channels)


def set_up(roving: int) -> Campaign:
    s, noise = 2j * np.pi * LINES, np.random.default_rng(roving)
    values = np.zeros((2, 1, LINES.size), complex)
    for f0, zeta, shape in MODES:
        w0 = 2 * np.pi * f0
        ends = np.array([shape[0], shape[roving - 1]])[:, None, None]
        values += ends * shape[0] * s**2 / (s**2 + 2 * zeta * w0 * s + w0**2)
    values += 1e-3 * (noise.normal(size=values.shape) + 1j * noise.normal(size=values.shape))
    frf = Frf(LINES, values, "inertance", ("stays", "roves"), (1, roving), (1,))
    return Campaign(rig(roving), (), (frf,), source=f"at{roving}.h5")


def test_frfs_of_set_ups_are_joined_by_the_sensor_that_stays() -> None:
    joined = identify_setups([set_up(k) for k in (2, 3, 4)], IdentificationOptions())
    model = joined.result.identified[0].model
    assert model.output_points == (1, 2, 3, 4)
    for mode, (f0, zeta, shape) in enumerate(MODES):
        assert model.frequency_hz[mode] == pytest.approx(f0, abs=4 * model.frequency_sigma_hz[mode])
        assert model.damping_ratio[mode] == pytest.approx(zeta, abs=4 * model.damping_sigma[mode])
        np.testing.assert_allclose(model.modal_constants[mode, :, 0].real, shape[0] * np.array(shape), rtol=2e-3)


def test_set_ups_at_other_lines_or_named_twice_are_rejected() -> None:
    one, other = set_up(2), set_up(3)
    (frf,) = other.frfs
    fewer = replace(frf, frequency_hz=LINES[::2], values=frf.values[..., ::2])
    with pytest.raises(DataError, match="lines in the band are not the"):
        identify_setups([one, replace(other, frfs=(fewer,))], IdentificationOptions())
    with pytest.raises(DataError, match=r"contains the same records as at2\.h5"):
        identify_setups([one, replace(one, source="again.h5")], IdentificationOptions())


def test_a_set_up_is_named_at_import(tmp_path: Path) -> None:
    rows = np.column_stack([LINES, *(p for v in set_up(2).frfs[0].values[:, 0] for p in (v.real, v.imag))])
    head = "Frequency [Hz],Re stays,Im stays,Re roves,Im roves"
    np.savetxt(tmp_path / "frf.csv", rows, delimiter=",", header=head, comments="")
    out = tmp_path / "frf.h5"
    assert main(["import", str(tmp_path / "frf.csv"), "--set-up", "left", "--out", str(out)]) == 0
    assert setup_names([read_campaign(out)]) == ("left",)
