"""Runs an exported MuJoCo model: forces in, what its accelerometers read out."""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.gap.export.mjcf import require_mujoco
from modallab.gap.simulations.simulated_records import Simulate


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
