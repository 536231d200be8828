"""`modallab rig check`, `modallab rig calibrate`, `modallab rig mass` and `modallab rig reset`."""

import argparse
from datetime import date

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from modallab.acquisition.process.trip import FOLDER as TRIPS
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench, DeliveredSampling
from modallab.cli.backup import require_data_folder
from modallab.commissioning import calibrate
from modallab.commissioning.calibrate import measure_mass_ratio
from modallab.commissioning.rig_check import (
    CLOCK_BURST_S,
    CheckResult,
    check_clock,
    check_idle,
    check_polarity,
    wait_for_sensors,
)
from modallab.commissioning.synchronisation_check import check_common_signal, check_synchronisation
from modallab.core.errors import PlanError, RigError, StorageError
from modallab.core.hardware import judge_mass_ratios
from modallab.core.rig import Channel, Rig
from modallab.formats.rig.mass_ratios_file import add_mass_ratio
from modallab.formats.rig.rig_file import read_rig, write_rig
from modallab.signals.conversion import sign_of, volts_per_count, volts_per_si

RATE_HZ = 2000.0


def run(arguments: argparse.Namespace) -> int:
    """Do what was asked for."""
    rig = read_rig(arguments.rig)
    url = arguments.bench or rig.bench
    if not url:
        raise RigError("names no bench", where=str(arguments.rig), remedy="give --bench ADDRESS, or a field bench")
    if arguments.action == "reset":
        return _reset(url, arguments)
    bench = open_bench(url, rig)
    try:
        return {"check": _check, "calibrate": _calibrate, "mass": _check_mass_ratio}[arguments.action](
            bench, rig, arguments
        )
    finally:
        bench.close()


def _reset(url: str, arguments: argparse.Namespace) -> int:
    if not arguments.data.is_dir():
        raise StorageError("is no folder", where=str(arguments.data), remedy="give the data folder of the recordings")
    if not (arguments.data / TRIPS).is_dir():
        # In another folder than that of the recordings no trip is found, and the rig may well be tripped.
        require_data_folder(arguments.data)
    trip = TripLatch(arguments.data, url).reset()
    outcome = (
        f"was tripped by {trip.cause} at {trip.utc}: {trip.what}; it may be armed again" if trip else "is not tripped"
    )
    Console().print(f"{url}: {outcome}", markup=False, highlight=False)
    return 0


def _check(bench: Bench, rig: Rig, arguments: argparse.Namespace) -> int:
    console = Console()
    findings = check_idle(bench, rig, arguments.seconds) + check_synchronisation(bench)
    if arguments.common is not None and arguments.drive is None:
        findings.append(check_common_signal(bench, rig, tuple(arguments.common)))
    if arguments.tap:
        findings += check_polarity(bench, rig, lambda point: console.print(f"tap point {point} now"))
    if arguments.drive is not None:
        if rig.limits is None:
            raise PlanError("the rig has no limits, and without them nothing is driven", remedy="add limits to the rig")
        if not 0 < arguments.drive <= rig.limits.drive_v:
            raise PlanError(
                f"--drive is {arguments.drive:g} V; allowed by limits.drive_v: above 0 to {rig.limits.drive_v:g} V",
                remedy="give another amplitude",
            )
        console.print(f"a burst of {CLOCK_BURST_S:g} s and {arguments.drive:g} V follows, and ends at 0 V")
        findings += check_clock(bench, rig, arguments.drive)
        if arguments.common is not None:
            findings.append(check_common_signal(bench, rig, tuple(arguments.common), arguments.drive))
    console.print(_table(findings))
    bad = sum(finding.verdict == "bad" for finding in findings)
    look = sum(finding.verdict == "look" for finding in findings)
    console.print(f"{len(findings)} checks: {bad} bad, {look} to look at")
    return 1 if bad else 0


def _table(findings: list[CheckResult]) -> Table:
    table = Table("channel", "what", "found", "verdict")
    for finding in findings:
        table.add_row(finding.channel, finding.what, finding.value, finding.verdict)
    return table


def _calibrate(bench: Bench, rig: Rig, arguments: argparse.Namespace) -> int:
    console = Console()
    channel = next((c for c in rig.channels if c.name == arguments.channel), None)
    if channel is None:
        raise RigError(
            f"has no channel {arguments.channel!r}",
            where=str(arguments.rig),
            remedy=f"choose one of {', '.join(c.name for c in rig.channels)}",
        )
    delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
    found = _measure_calibration(bench, rig, delivery, channel, arguments)
    was = channel.sensitivity("impact")
    new = calibrate.with_calibration(rig, channel, arguments.method, found, date.today(), arguments.remark)  # noqa: DTZ011
    entry = new.history[-1]
    console.print(
        f"{channel.name}: {entry.sensitivity_v_per_unit:.6g} +- {entry.sigma_v_per_unit:.2g} V per {channel.unit}"
        f" (was {was:.6g})"
    )
    out = arguments.out or arguments.rig
    write_rig(new, out)
    console.print(f"added to the history of {out}", markup=False)
    return 0


def _check_mass_ratio(bench: Bench, rig: Rig, arguments: argparse.Namespace) -> int:
    console = Console()
    delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
    _wait_for(arguments, "strike or shake the free mass")
    volts = _read_volts(bench, rig, delivery, arguments.seconds)
    sensor = _accelerometer(rig, arguments)
    ratio = measure_mass_ratio(rig, volts, sensor, arguments.mass, arguments.when, date.today())  # noqa: DTZ011
    judgements = judge_mass_ratios(add_mass_ratio(arguments.into, ratio))
    for judgement in judgements:
        console.print(f"{'good' if judgement.within else 'bad'}: {judgement.what}", markup=False, highlight=False)
    return 0 if all(judgement.within for judgement in judgements) else 1


def _wait_for(arguments: argparse.Namespace, what: str) -> None:
    """Wait until somebody has done it.

    Raises:
        PlanError: nobody is at the terminal.
    """
    if arguments.yes:
        return
    try:
        input(f"{what}, then press Enter ")
    except EOFError as error:
        raise PlanError(
            f"no terminal to press Enter after this step: {what}",
            remedy="run the command in a terminal, or give --yes if the step is done",
        ) from error


def _accelerometer(rig: Rig, arguments: argparse.Namespace) -> Channel:
    name = arguments.against or rig.responses[0].name
    for channel in rig.responses:
        if channel.name == name:
            return channel
    raise RigError(
        f"has no sensor {name!r}",
        where=str(arguments.rig),
        remedy=f"choose one of {', '.join(c.name for c in rig.responses)}",
    )


def _measure_calibration(
    bench: Bench, rig: Rig, delivery: DeliveredSampling, channel: Channel, arguments: argparse.Namespace
) -> tuple[float, float]:
    def record(what: str) -> NDArray[np.float64]:
        _wait_for(arguments, what)
        return _read_volts(bench, rig, delivery, arguments.seconds)

    row, value = channel.index, arguments.value
    if arguments.method == "turnover":
        return calibrate.sensitivity_by_turnover(record("axis up")[row], record("axis down")[row])
    if value is None:
        raise PlanError(f"the {arguments.method} calibration needs --value", remedy="see modallab rig calibrate --help")
    if arguments.method == "shunt":
        return calibrate.sensitivity_by_step(record("shunt open")[row], record("shunt closed")[row], value)
    if arguments.method == "reference":
        volts = record("reference shaker on")[row]
        return calibrate.sensitivity_by_reference(volts, delivery.rate_hz, arguments.frequency, value)
    volts = record("shake the free mass")
    sensor = _accelerometer(rig, arguments)
    # Positive along the drive on both sides; the force channel's own direction turns its sensitivity back.
    acceleration = volts[sensor.index] / volts_per_si(rig, "impact")[sensor.index]
    return calibrate.sensitivity_by_rigid_mass(sign_of(rig, channel) * volts[row], acceleration, value)


def _read_volts(bench: Bench, rig: Rig, delivery: DeliveredSampling, seconds: float) -> NDArray[np.float64]:
    bench.start()
    try:
        wait_for_sensors(bench, rig, delivery)
        chunk = bench.read(max(1, round(seconds * delivery.rate_hz)), seconds + 5.0)
    finally:
        bench.stop()
    scale = volts_per_count(rig, "impact", delivery.units, delivery.scale)
    return chunk.samples.astype(np.float64) * scale[:, None]
