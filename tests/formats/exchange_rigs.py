"""Rigs as an operator writes them, for the tests of this folder."""

from typing import Any

import yaml

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig


def beam_content(n_points: int = 3) -> dict[str, Any]:
    """A cantilever with `n_points` accelerometers, as the plain content of its file."""
    points = [{"id": k, "x_m": round(0.887 * k / n_points, 6)} for k in range(1, n_points + 1)]
    force = {"index": 0, "name": "force", "quantity": "force", "unit": "N"}
    force["sensitivity_v_per_unit"] = {"impact": 0.02, "sine": 0.5}
    sensors = [
        {
            "index": k,
            "name": f"a{k:02d}",
            "quantity": "acceleration",
            "unit": "m/s^2",
            "point": k,
            "sensitivity_v_per_unit": {"impact": 0.01, "sine": 0.1},
        }
        for k in range(1, n_points + 1)
    ]
    beam = {"length_m": 0.887, "width_m": 0.0511, "thickness_m": 0.00399}
    beam |= {"youngs_modulus_pa": 205e9, "density_kg_m3": 7850.0}
    return {"name": "elastic link", "beam": beam, "points": points, "channels": [force, *sensors], "shaker_point": 2}


def beam_rig(n_points: int = 3) -> Rig:
    return parse_rig(yaml.safe_dump(beam_content(n_points)), "rig.yaml")


def plain_rig(*names: str) -> Rig:
    """An unknown structure: force, then accelerations without a point."""
    channels: list[dict[str, Any]] = [{"index": 0, "name": "force", "quantity": "force", "unit": "N"}]
    for index, name in enumerate(names or ("acceleration",), start=1):
        channels.append({"index": index, "name": name, "quantity": "acceleration", "unit": "m/s^2"})
    return parse_rig(yaml.safe_dump({"name": "structure", "model": "unknown", "channels": channels}), "rig.yaml")
