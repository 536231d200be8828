"""The twin as a MuJoCo model: a chain of links, a motor at each point of the rig, an accelerometer at each channel's.

Joints along x hinge about -y, so that the free end rises along z. Fixed tendons hold stiffness and damping: a
combination of joints each; a cubic spring and a free play are one more. There is no gravity: what is simulated is the
motion about rest.
"""

from importlib import import_module
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from modallab.core.arrays import Real
from modallab.core.discovery import optional_package
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.atomic import write_text
from modallab.gap.export.chain import JointedChain, chain_of_structure, joint_combinations
from modallab.gap.export.mjcf_laws import tendon_of_law
from modallab.gap.simulations.simulated_records import Simulate
from modallab.twin.bench import Twin

STEP_S = 1 / 32000
SMALL = 1e-4
"""Radius of gyration of a node's mass over its link's length: a mass without inertia cannot be simulated."""
LEAST_INERTIA_KG_M2 = 1e-14
"""MuJoCo takes none below 1e-15. Where a sensor stands half a millimetre from where hits land, the link between is so
short that the share above falls below it; this is still a radius of gyration of micrometres."""


def write_mjcf(path: Path, twin: Twin, rig: Rig, test: Test) -> None:
    """Write the structure in one test as MJCF. The measurement chain stays outside, but for gains.

    Raises:
        MissingPackageError: MuJoCo is not installed.
        DataError: a response channel is no accelerometer, MuJoCo has no spring with a law of the twin, or the twin has
            modes beside those of bending.
        StorageError: the file cannot be written.
    """
    text = mjcf_text(twin, rig, test)
    write_text(path, text)


def mjcf_text(twin: Twin, rig: Rig, test: Test) -> str:
    """The same as text; errors as there."""
    others = [c.name for c in rig.responses if c.quantity != "acceleration"]
    if others:
        raise DataError(
            f"{', '.join(others)} are no accelerometers, and the MuJoCo export supports only accelerometers",
            where=rig.name,
            remedy="export the state space",
        )
    if twin.structure.side:
        raise DataError(
            f"the link swings beside bending as well ({', '.join(one.family for one in twin.structure.side)}), and a "
            "chain of hinges bends only",
            where=rig.name,
            remedy="export the state space or the modal model",
        )
    structure = twin.structure
    if test == "sine" and rig.shaker_point is not None:
        structure = twin.in_sine(rig.x_of(rig.shaker_point))
    length = structure.length_m
    sensors = {
        c.name: _interpolation_on(rig.x_of(c.point or 0) + twin.chain.shift.get(c.index, 0.0), length)
        for c in rig.responses
    }
    points = {p.id: twin.struck_x_m(p.x_m) if test == "impact" else p.x_m for p in rig.points}
    acts = [] if twin.element is None else [twin.element.x_m]
    found = chain_of_structure(structure, np.array([*sensors.values(), *points.values(), *acts]))
    root = _bodies_xml(found, rig, sensors, points)
    mass = mass_matrix(ET.tostring(root, encoding="unicode"))
    names = [*(["slide"] if found.slides else []), *(f"hinge{k}" for k in range(1, len(found.nodes_m)))]
    tendons = _tendons_of_modes(found, mass)
    if twin.element is not None:
        tendons["law"] = tendon_of_law(twin.element, structure, found, mass)
    _add_tendons(root, names, tendons)
    gains = {c.name: twin.chain.gain.get(c.index, 1.0) / twin.chain.force_gain for c in rig.responses}
    custom = ET.SubElement(root, "custom")
    for name, gain in gains.items():
        ET.SubElement(custom, "numeric", name=f"gain_{name}", data=_number(gain))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _bodies_xml(found: JointedChain, rig: Rig, sensors: dict[str, float], points: dict[int, float]) -> ET.Element:
    root = ET.Element("mujoco", model=rig.name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    # Steps that are short enough for the fastest combination; nothing damps but what the twin damps.
    ET.SubElement(root, "option", timestep=_number(STEP_S), gravity="0 0 0", integrator="RK4")
    body = ET.SubElement(root, "worldbody")
    nodes = found.nodes_m
    if found.slides:
        body = ET.SubElement(body, "body", name="clamp")
        ET.SubElement(body, "joint", name="slide", type="slide", axis="0 0 1")
        _inertia(body, 0.0, float(found.masses_kg[0]), float(nodes[1]))
    for k in range(1, len(nodes)):
        link = float(nodes[k] - nodes[k - 1])
        before = float(nodes[k - 1] - nodes[k - 2]) if k > 1 else 0.0
        body = ET.SubElement(body, "body", name=f"link{k}", pos=f"{_number(before)} 0 0")
        ET.SubElement(body, "joint", name=f"hinge{k}", type="hinge", axis="0 -1 0")
        _inertia(body, link, float(found.masses_kg[k]), link)
        ET.SubElement(body, "geom", type="capsule", size="0.002", fromto=f"0 0 0 {_number(link)} 0 0", mass="0",
                      contype="0", conaffinity="0")  # fmt: skip
        here = f"{_number(link)} 0 0"
        for name in (f"point{p}" for p, x in points.items() if abs(x - nodes[k]) < 1e-8):
            ET.SubElement(body, "site", name=name, pos=here)
        for name in (name for name, x in sensors.items() if abs(x - nodes[k]) < 1e-8):
            ET.SubElement(body, "site", name=name, pos=here)
    actuator, sensor = ET.SubElement(root, "actuator"), ET.SubElement(root, "sensor")
    for point in points:
        ET.SubElement(actuator, "motor", name=f"force{point}", site=f"point{point}", gear="0 0 1 0 0 0")
    for name in sensors:
        ET.SubElement(sensor, "accelerometer", name=f"acceleration_{name}", site=name)
    return root


def _inertia(body: ET.Element, at: float, mass_kg: float, link_m: float) -> None:
    small = _number(max(mass_kg * (SMALL * link_m) ** 2, LEAST_INERTIA_KG_M2))
    ET.SubElement(body, "inertial", pos=f"{_number(at)} 0 0", mass=_number(mass_kg), diaginertia=" ".join([small] * 3))


def _tendons_of_modes(found: JointedChain, mass: Real) -> dict[str, tuple[Real, dict[str, str]]]:
    """Name -> what it takes of each joint, and its spring and damper: one for each mode and each damper."""
    return {
        f"mode{k}": (row, {"stiffness": _number(stiffness), "damping": _number(damping), "springlength": "0"})
        for k, (row, stiffness, damping) in enumerate(joint_combinations(found, mass), 1)
    }


def _add_tendons(root: ET.Element, joints: list[str], tendons: dict[str, tuple[Real, dict[str, str]]]) -> None:
    tendon = ET.SubElement(root, "tendon")
    for name, (row, spring) in tendons.items():
        fixed = ET.SubElement(tendon, "fixed", {"name": name, **spring})
        for joint, coefficient in zip(joints, row, strict=True):
            ET.SubElement(fixed, "joint", joint=joint, coef=_number(float(coefficient)))


def mass_matrix(text: str) -> Real:
    """(joints, joints) of a model at rest, as MuJoCo has it.

    Raises:
        MissingPackageError: MuJoCo is not installed.
    """
    mujoco = require_mujoco()
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


def require_mujoco() -> Any:
    """The library.

    Raises:
        MissingPackageError: it is not installed.
    """
    return optional_package("mujoco", "a MuJoCo model")


def _interpolation_on(x_m: float, length_m: float) -> float:
    return min(max(x_m, 0.0), length_m)


def _number(value: float) -> str:
    return repr(float(value))


def mujoco_simulation(path: Path, rig: Rig) -> Simulate:
    """The model of a file as a function of force and time step.

    Raises:
        MissingPackageError: MuJoCo is not installed.
        FormatError: MuJoCo does not take the file.
        DataError: it has no motor or accelerometer for a point or a channel of the rig.
    """
    mujoco = require_mujoco()
    try:
        model: Any = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise FormatError(f"MuJoCo rejects the model: {error}", where=str(path), remedy="export it again") from error
    motors = [_mujoco_id(mujoco, model, "ACTUATOR", f"force{p.id}", path) for p in rig.points]
    rows = [
        int(model.sensor_adr[_mujoco_id(mujoco, model, "SENSOR", f"acceleration_{c.name}", path)]) + 2
        for c in rig.responses
    ]
    gains = np.array([_motor_gain(mujoco, model, f"gain_{c.name}") for c in rig.responses])

    def simulate(force_n: Real, dt: float) -> Real:
        model.opt.timestep = dt
        at_once = _static_acceleration(mujoco, model, motors, rows)
        # A control is held over its step: its middle is what the straight line has in the mean.
        following = np.concatenate([force_n[:, 1:], force_n[:, -1:]], axis=1)
        middle = (force_n + following) / 2
        control = np.zeros((1, force_n.shape[1], model.nu))
        control[0][:, motors] = middle.T
        initial = np.zeros((1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
        _, sensed = _rollout(model, mujoco.MjData(model), initial, control)
        # Sensors are read at the start of a step, where the force is not yet its middle.
        return gains[:, None] * (sensed[0][:, rows].T + at_once @ (force_n - middle))

    return simulate


def _rollout(model: Any, data: Any, initial: Real, control: Real) -> tuple[Real, Real]:
    rollout: Any = import_module("mujoco.rollout")
    state, sensed = rollout.rollout(model, data, initial, control)
    return np.asarray(state), np.asarray(sensed)


def _static_acceleration(mujoco: Any, model: Any, motors: list[int], rows: list[int]) -> Real:
    """(channels, points) acceleration at rest for 1 N."""
    data = mujoco.MjData(model)
    columns: list[Real] = []
    for motor in motors:
        data.ctrl[:] = 0.0
        data.ctrl[motor] = 1.0
        mujoco.mj_forward(model, data)
        columns.append(np.array(data.sensordata[rows]))
    return np.array(columns).T


def _mujoco_id(mujoco: Any, model: Any, kind: str, name: str, path: Path) -> int:
    found = mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), name)
    if found < 0:
        raise DataError(f"has no {kind.lower()} {name!r}", where=str(path), remedy="export the model for this rig")
    return int(found)


def _motor_gain(mujoco: Any, model: Any, name: str) -> float:
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    return 1.0 if found < 0 else float(model.numeric_data[model.numeric_adr[found]])
