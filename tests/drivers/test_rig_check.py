"""`rig check`, `rig calibrate` and `devices`: verdicts against what is truly on the simulated bench."""

from datetime import date
from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer

from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import find_devices, open_bench
from modallab.cli import main
from modallab.commissioning import calibrate
from modallab.commissioning.rig_check import check_clock, check_idle, check_polarity
from modallab.core.errors import ConfigurationError, DataError
from modallab.core.rig import Rig
from modallab.core.units import STANDARD_GRAVITY
from modallab.formats.rig.rig_file import read_rig, write_rig

SIM = "sim://cantilever?seed=1&bad_hits=0"
RNG = np.random.default_rng(4)


def verdicts(findings, what: str) -> dict[str, str]:
    return {finding.channel: finding.verdict for finding in findings if finding.what == what}


def changed(rig: Rig, index: int, **fields: object) -> Rig:
    channels = list(rig.channels)
    channels[index] = channels[index].model_copy(update=fields)
    return rig.model_copy(update={"channels": tuple(channels)})


def test_a_good_bench_at_rest_is_good(rig: Rig):
    bench = open_bench(SIM, rig)
    findings = check_idle(bench, rig, 1.0)
    assert {finding.verdict for finding in findings} == {"good"}
    assert len(findings) == 3 * len(rig.channels)
    bench.close()


def test_more_noise_than_believed_is_to_look_at(rig: Rig):
    assert rig.converter is not None
    optimistic = rig.model_copy(update={"converter": rig.converter.model_copy(update={"noise_rms_v": 2e-5})})
    bench = open_bench(SIM, rig)
    assert set(verdicts(check_idle(bench, optimistic, 1.0), "noise").values()) == {"look"}
    bench.close()


def test_a_turned_sensor_is_found_by_a_tap_at_its_point(rig: Rig):
    # Truly turned, while the rig file believes it is not.
    bench = open_bench(SIM, changed(rig, 7, direction="-z"))
    asked: list[int] = []
    found = verdicts(check_polarity(bench, rig, asked.append), "polarity")
    bench.close()
    assert asked == list(range(1, 11))
    assert found.pop("a07") == "bad"
    # Near the clamp a tap moves little: a person may have to look.
    assert set(found.values()) <= {"good", "look"}
    assert sum(verdict == "good" for verdict in found.values()) >= 7


def test_the_generators_clock_is_compared_with_the_converters(rig: Rig):
    bench = open_bench(SIM, rig)
    finding = check_clock(bench, rig, 0.5)[0]
    true_ppm = float(bench.info.facts["generator_ppm"])
    bench.close()
    assert finding.verdict == "good"
    assert float(finding.value.split()[0]) == pytest.approx(true_ppm, abs=5.0)


def test_a_sensor_that_says_another_sensitivity_is_bad(rig: Rig):
    assert rig.converter is not None
    iepe = rig.model_copy(
        update={
            "converter": rig.converter.model_copy(update={"range_v": 5.0}),
            "channels": tuple(
                c.model_copy(update={"coupling": "IEPE" if c.quantity == "acceleration" else "DC", "range_v": 5.0})
                for c in rig.channels
            ),
        }
    )
    with NiServer(iepe, "9234") as server:
        believed = changed(iepe, 3, sensitivity_v_per_unit=0.02)
        bench = open_bench(server.url, believed)
        found = verdicts(check_idle(bench, believed, 0.5), "sensor")
        bench.close()
    assert found.pop("a03") == "bad"
    assert set(found.values()) == {"good"}
    assert len(found) == 9


def test_turnover_and_step_and_reference_and_mass_give_the_sensitivity():
    noise = RNG.standard_normal((2, 4000)) * 1e-4
    up, down = 0.02 * STANDARD_GRAVITY + 0.7 + noise[0], -0.02 * STANDARD_GRAVITY + 0.7 + noise[1]
    value, sigma = calibrate.sensitivity_by_turnover(up, down)
    assert value == pytest.approx(0.02, abs=5 * sigma)
    assert sigma < 1e-6
    assert calibrate.sensitivity_by_step(down, up, -1.0)[0] < 0
    t = np.arange(4000) / 2000
    shaken = 0.05 * 10 * np.sqrt(2) * np.sin(2 * np.pi * 159.15 * t) + noise[0]
    value, sigma = calibrate.sensitivity_by_reference(shaken, 2000.0, 159.15, 10.0)
    assert value == pytest.approx(0.05, abs=5 * sigma)
    acceleration = RNG.standard_normal(4000)
    value, sigma = calibrate.sensitivity_by_rigid_mass(0.5 * 1.2 * acceleration + noise[0], acceleration, 1.2)
    assert value == pytest.approx(0.5, abs=5 * sigma)


def test_what_was_not_turned_shaken_or_coupled_is_rejected():
    noise = RNG.standard_normal((2, 4000)) * 1e-4
    with pytest.raises(DataError, match="no step was detected"):
        calibrate.sensitivity_by_turnover(noise[0], noise[1])
    with pytest.raises(DataError):
        calibrate.sensitivity_by_reference(noise[0], 2000.0, 159.15, 10.0)
    with pytest.raises(DataError, match="one rigid mass"):
        calibrate.sensitivity_by_rigid_mass(noise[0], noise[1], 1.0)


def test_a_calibration_is_dated_in_the_rigs_history_and_survives_the_file(rig: Rig, tmp_path: Path):
    one = changed(rig, 4, sensitivity_v_per_unit=0.01)
    new = calibrate.with_calibration(one, one.channels[4], "turnover", (0.0123, 1e-5), date(2026, 3, 4), "new cable")
    write_rig(new, tmp_path / "rig.yaml")
    read = read_rig(tmp_path / "rig.yaml")
    assert read == new
    assert read.channels[4].sensitivity("sine") == 0.0123
    assert read.channels[4].calibrated_on == date(2026, 3, 4)
    assert read.history[0].channel == "a04"


def test_a_calibration_leaves_the_other_tests_sensitivity_and_the_sign_alone(rig: Rig):
    turned = changed(rig, 0, sensitivity_v_per_unit={"impact": -0.02, "sine": -0.5})
    new = calibrate.with_calibration(turned, turned.channels[0], "rigid-mass", (0.0201, 1e-5), date(2026, 3, 4))
    assert new.channels[0].sensitivity_v_per_unit == {"impact": -0.0201, "sine": -0.5}
    assert new.history[0].sensitivity_v_per_unit == -0.0201
    assert new.history[0].test == "impact"


def test_the_commands_say_what_they_found(rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    write_rig(rig, tmp_path / "rig.yaml")
    assert main(["rig", "check", str(tmp_path / "rig.yaml"), "--bench", SIM, "--seconds", "0.5"]) == 0
    assert "33 checks: 0 bad" in capsys.readouterr().out
    # A simulated sensor can't be turned over: that is seen, and nothing is written.
    command = ["rig", "calibrate", str(tmp_path / "rig.yaml"), "--bench", SIM, "--channel", "a04", "--yes"]
    assert main([*command, "--method", "turnover", "--seconds", "0.5"]) == 2
    assert "no step was detected" in capsys.readouterr().err
    assert read_rig(tmp_path / "rig.yaml").history == ()


def test_a_tripped_rig_is_reset_by_a_command(rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = tmp_path / "rig.yaml"
    write_rig(rig.model_copy(update={"bench": "nidaqmx://cDAQ1"}), file)
    latch = TripLatch(tmp_path / "data", "nidaqmx://cDAQ1")
    latch.trip("emergency stop", "by the operator")
    command = ["rig", "reset", str(file), "--data", str(tmp_path / "data")]
    assert main(command) == 0
    assert "was tripped by emergency stop" in capsys.readouterr().out.replace("\n", " ")
    assert not latch.is_tripped
    assert main(command) == 0
    assert "is not tripped" in capsys.readouterr().out


def test_devices_of_a_server_are_listed_with_their_addresses(ni_server: NiServer, capsys: pytest.CaptureFixture[str]):
    server = ni_server.url.rpartition("/")[0]
    assert main(["devices", server]) == 0
    out = capsys.readouterr().out
    assert f"{server}/cDAQ1Mod1" in out
    assert "NI 9215" in out
    with pytest.raises(ConfigurationError):
        find_devices("nowhere://")


def fed(rig: Rig) -> Rig:
    """The rig with every sensor on an IEPE input of +-5 V, the force too."""
    assert rig.converter is not None
    channels = tuple(c.model_copy(update={"coupling": "IEPE", "range_v": 5.0}) for c in rig.channels)
    return rig.model_copy(update={"converter": rig.converter.model_copy(update={"range_v": 5.0}), "channels": channels})


@pytest.mark.parametrize(
    "system", ["9234", pytest.param("4431", marks=pytest.mark.thorough("waits for a device once more"))]
)
def test_cold_sensors_are_waited_for_and_then_good(rig: Rig, system: str):
    # 4.9 V of bias fade to the noise; the USB device has DC as its default and would read 10 V for ever.
    iepe = fed(rig)
    if system == "4431":
        assert iepe.limits is not None
        limits = iepe.limits.model_copy(update={"drive_v": 3.0})
        iepe = iepe.model_copy(update={"channels": iepe.channels[:4], "limits": limits})
    with NiServer(iepe, system) as server:
        bench = open_bench(server.url, iepe)
        findings = check_idle(bench, iepe, 1.0)
        bench.close()
    waited = verdicts(findings, "supply")
    assert len(waited) == len(iepe.channels)
    assert {f.verdict for f in findings if f.what in ("supply", "noise", "offset", "overload")} == {"good"}


def test_a_supply_the_device_does_not_have_is_rejected_with_those_it_has(rig: Rig):
    iepe = fed(rig)
    with (
        NiServer(iepe, "9234") as server,
        pytest.raises(ConfigurationError, match=r"excitation_a: found 0\.004"),
    ):
        open_bench(server.url, changed(iepe, 2, excitation_a=0.004))
