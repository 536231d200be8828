"""Certificates and sensors against the rig file: expired is reported, a contradiction is rejected."""

from datetime import date
from pathlib import Path

import pytest
from ni_server import NiServer

from modallab.acquisition.procedures.sensors import sensor_remarks
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.core.errors import RigError
from modallab.core.events import Event, OperatorNotice
from modallab.core.hardware import Calibration, Certificate
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import dump_rig, read_rig, write_rig
from modallab.storage import Store

SIM = "sim://cantilever?seed=1&bad_hits=0"
TODAY = date(2026, 6, 1)


def certified(rig: Rig, index: int, **fields: object) -> Rig:
    channel = rig.channels[index]
    serial = channel.serial or "4711"
    known = {"serial": serial, "number": "K-1", "date": date(2026, 1, 1), "uncertainty_percent": 1.0}
    channels = list(rig.channels)
    channels[index] = channel.model_copy(
        update={"certificate": Certificate.model_validate(known | fields), "serial": serial}
    )
    return rig.model_copy(update={"channels": tuple(channels)})


def test_a_valid_certificate_is_not_remarked_on(rig: Rig):
    believed = rig.channels[3].sensitivity("impact")
    good = certified(rig, 3, sensitivity_v_per_unit=1.009 * believed, expires=TODAY)
    assert sensor_remarks(good, "impact", TODAY) == []


def test_an_expired_one_is_remarked_on_and_no_contradiction(rig: Rig):
    (remark,) = sensor_remarks(certified(rig, 3, expires=date(2026, 5, 31)), "impact", TODAY)
    assert not remark.contradiction
    assert "K-1" in remark.what
    assert "2026-05-31" in remark.what


def test_another_sensor_or_another_sensitivity_is_a_contradiction(rig: Rig):
    believed = rig.channels[3].sensitivity("impact")
    (other,) = sensor_remarks(certified(rig, 3, serial="9999"), "impact", TODAY)
    assert other.contradiction
    off = certified(rig, 3, sensitivity_v_per_unit=1.02 * believed)
    (wrong,) = sensor_remarks(off, "impact", TODAY)
    assert wrong.contradiction
    assert "-1.96 %" in wrong.what
    # Calibrated on the bench since: that counts.
    name = rig.channels[3].name
    since = Calibration(date=date(2026, 3, 1), channel=name, method="reference", sensitivity_v_per_unit=1.0)
    assert sensor_remarks(off.model_copy(update={"history": (since,)}), "impact", TODAY) == []


def test_a_run_reports_what_is_expired_and_rejects_what_contradicts(rig: Rig, tmp_path: Path):
    expired = certified(rig, 3, expires=date(2020, 1, 1))
    plan = ImpactPlan(points=(3,), hits=1)
    events: list[Event] = []
    with Store(tmp_path) as store:
        bench = open_bench(SIM, expired)
        record_run(bench, expired, plan, store, events.append)
        bench.close()
        assert any(isinstance(event, OperatorNotice) and "expired on 2020-01-01" in event.what for event in events)
        wrong = certified(rig, 3, serial="9999")
        bench = open_bench(SIM, wrong)
        with pytest.raises(RigError, match="9999"):
            record_run(bench, wrong, plan, store, events.append)
        bench.close()


def test_sensors_say_themselves_which_they_are(rig: Rig):
    assert rig.converter is not None
    fed = [
        c.model_copy(update={"coupling": "IEPE", "range_v": 5.0, "serial": f"LW{100 + c.index}"}) for c in rig.channels
    ]
    truth = [c.model_copy(update={"serial": str(100 + c.index)}) for c in fed]
    truth[0] = truth[0].model_copy(update={"serial": "777"})
    converter = rig.converter.model_copy(update={"range_v": 5.0})
    mounted = rig.model_copy(update={"converter": converter, "channels": tuple(truth)})
    believed = rig.model_copy(update={"converter": converter, "channels": tuple(fed)})
    with NiServer(mounted, "9234") as server:
        bench = open_bench(server.url, believed)
        remarks = sensor_remarks(believed, "impact", TODAY, bench)
        bench.close()
    # The force transducer has been changed; it has a data sheet as the others have.
    assert [remark.channel for remark in remarks] == [rig.channels[0].name]
    assert "777" in remarks[0].what


def test_a_file_of_sensors_is_put_to_the_channels_by_serial(rig: Rig, tmp_path: Path):
    serials = [c.model_copy(update={"serial": f"S{c.index}"}) for c in rig.channels]
    plain = rig.model_copy(update={"channels": tuple(serials)})
    (tmp_path / "sensors.yaml").write_text(
        "- {serial: S2, number: old, date: 2020-01-01, uncertainty_percent: 5}\n"
        "- {serial: S2, number: new, date: 2025-01-01, laboratory: DKD, uncertainty_percent: 1.2}\n"
    )
    (tmp_path / "rig.yaml").write_text(dump_rig(plain) + "sensors: sensors.yaml\n")
    read = read_rig(tmp_path / "rig.yaml")
    assert [c.certificate is not None for c in read.channels] == [c.index == 2 for c in read.channels]
    assert read.channels[2].certificate is not None
    assert read.channels[2].certificate.number == "new"
    # Written again it holds them itself.
    write_rig(read, tmp_path / "whole.yaml")
    assert read_rig(tmp_path / "whole.yaml") == read
    (tmp_path / "sensors.yaml").write_text("- {serial: S2, date: 2020-01-01, uncertainty_percent: -1}\n")
    with pytest.raises(RigError, match="uncertainty_percent"):
        read_rig(tmp_path / "rig.yaml")


def test_a_rig_without_certificates_is_written_as_before(rig: Rig):
    assert "certificate" not in rig.model_dump_json()
    assert "synchronisation" not in rig.model_dump_json()
