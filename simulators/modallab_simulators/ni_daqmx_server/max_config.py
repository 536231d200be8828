"""Systems as the vendor's configuration files describe them: devices, scales, saved channels and tasks."""

from collections.abc import Callable
from configparser import ConfigParser
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import CHASSIS_KINDS, Chassis, Layout, module

Section = dict[str, str]


def numbers(text: str) -> list[float]:
    """Numbers of a list as it is saved."""
    return [float(part) for part in text.split(",") if part.strip()]


def scaling(saved: dict[str, Section], name: str) -> Callable[[Floats], Floats]:
    """The function of a scale.

    Raises:
        StatusError: there is no such scale.
    """
    if name not in saved:
        raise StatusError(status.NO_SUCH_SCALE, f"Custom Scale: {name}")
    section = saved[name]
    kind = section["ScaleType"]
    if kind == "Linear":
        slope, first = float(section["Lin.Slope"]), float(section["Lin.YIntercept"])
        return lambda values: slope * values + first
    if kind == "Polynomial":
        coefficients = numbers(section["Poly.ForwardCoeff"])
        return lambda values: np.asarray(np.polynomial.polynomial.polyval(values, coefficients), np.float64)
    if kind == "Map Ranges":
        before = [float(section["Map.PreScaledMin"]), float(section["Map.PreScaledMax"])]
        after = [float(section["Map.ScaledMin"]), float(section["Map.ScaledMax"])]
        return lambda values: after[0] + (values - before[0]) * (after[1] - after[0]) / (before[1] - before[0])
    known, given = numbers(section["Table.PreScaledVals"]), numbers(section["Table.ScaledVals"])
    return lambda values: np.interp(values, known, given)


@dataclass(frozen=True, slots=True)
class SavedConfiguration:
    """What else a configuration holds, each by its name."""

    scales: dict[str, Section] = field(default_factory=dict[str, Section])
    channels: dict[str, Section] = field(default_factory=dict[str, Section])
    tasks: dict[str, Section] = field(default_factory=dict[str, Section])
    accessories: dict[str, str] = field(default_factory=dict[str, str])


def read(files: list[Path]) -> tuple[Layout, SavedConfiguration]:
    """Everything that these files describe together.

    Raises:
        KeyError: a product that cannot be simulated.
    """
    chassis: dict[str, Chassis] = {}
    modules: dict[str, Module] = {}
    saved = SavedConfiguration()
    for file in files:
        parser = ConfigParser(interpolation=None, strict=False)
        parser.optionxform = str  # pyrefly: ignore[method-assign, bad-assignment]  # names keep their case
        parser.read_string(file.read_text(encoding="utf-8-sig"))
        for title in parser.sections():
            kind, _, name = title.partition(" ")
            section = {key: value.strip().strip('"') for key, value in parser[title].items()}
            if kind == "DAQmxCDAQChassis":
                chassis[name] = _chassis(name, section)
            elif kind in ("DAQmxDevice", "DAQmxCDAQModule"):
                modules[name] = _module(name, section)
            else:
                _keep(saved, kind, name, section)
    return Layout(tuple(chassis.values()), tuple(modules.values())), saved


def _chassis(name: str, section: Section) -> Chassis:
    product = section["ProductType"]
    if product not in CHASSIS_KINDS:
        raise KeyError(f"the chassis {product} cannot be simulated")
    return Chassis(name, product, int(section["DevSerialNum"], 16), section["DevIsSimulated"] == "1")


def _module(name: str, section: Section) -> Module:
    made = module(
        section["ProductType"], name, int(section["DevSerialNum"], 16),
        section.get("CompactDAQ.ChassisDevName", ""), int(section.get("CompactDAQ.SlotNum", "0")),
    )  # fmt: skip
    return replace(
        made,
        simulated=section["DevIsSimulated"] == "1",
        product_number=int(section.get("ProductNum", "0"), 16),
    )


def _keep(saved: SavedConfiguration, kind: str, name: str, section: Section) -> None:
    if kind == "DAQmxScale":
        saved.scales[name] = section
    elif kind == "DAQmxChannel":
        saved.channels[name] = section
    elif kind == "DAQmxTask":
        saved.tasks[name] = section
    elif kind == "DAQmxAccessory":
        accessory, device = name.split("/")[:2]
        saved.accessories[device] = accessory
