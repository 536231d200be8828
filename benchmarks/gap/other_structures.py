"""Blind trials on structures that no beam describes: a plate and a tube, each before and after one withheld change.

    OPENBLAS_NUM_THREADS=1 python benchmarks/gap/other_structures.py --trials 60 --out trials.jsonl
    python benchmarks/gap/other_structures.py --score trials.jsonl

A trial is two modal tests: FRFs of the structure as it was, which modallab identifies and takes for the simulation, and
FRFs of it as it is. In between E, density and thickness have strayed, stiffness and mass are spread otherwise, every
sensor was mounted anew (place, sensitivity, cable), every point struck anew (place, force), damping is another, all
within a lab's usual tolerances; and one thing is wrong: a mass, a spring to ground, a sensor's gain, a sensor's place.
With `none` of them the right answer is no gap. With --elements the structure's model itself is the simulation.
Physics: `structures.py`. Noise: 0.1 % of each FRF's rms.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from structures import PLATE_M, RADIUS_M, TUBE_M, Material, Matrices, field, plate, tube, with_mass, with_spring

from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig, Tolerance
from modallab.formats.fem.fem_file import FemModel
from modallab.formats.modes import NodeModes
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.mesh import Mesh
from modallab.updating.elements import mesh_shapes, model_of_elements

Real = NDArray[np.float64]
KINDS = ("added_mass", "ground_spring", "gain_error", "position_error")
TOLERANCE = Tolerance.usual()
ZETA, NOISE, MODES, HITS = 0.004, 0.001, 40, 5


@dataclass(frozen=True)
class Bench:
    """A structure with its points: sensors are (point, axis), hits are points struck along +z."""

    name: str
    make: Any
    points: Real
    sensors: tuple[tuple[int, str], ...]
    hits: tuple[int, ...]
    band_hz: tuple[float, float]
    step_hz: float

    @property
    def rig(self) -> Rig:
        points = tuple(Point(id=n + 1, x_m=x, y_m=y, z_m=z) for n, (x, y, z) in enumerate(self.points.tolist()))
        force = Channel(index=0, name="force", quantity="force", unit="N")
        channels = tuple(
            Channel(
                index=n + 1, name=f"a{n + 1:02d}", quantity="acceleration", unit="m/s^2", point=p, direction=f"+{a}"
            )
            for n, (p, a) in enumerate(self.sensors)
        )
        return Rig(name=self.name, model="unknown", tolerance=TOLERANCE, points=points, channels=(force, *channels))


def benches() -> dict[str, Bench]:
    """Roving hammer on the plate: 6 x 4 points, 4 sensors. On the tube 12 points, two sensors each, 3 struck."""
    x, y = np.meshgrid(np.linspace(1 / 6, 1, 6) * PLATE_M[0], np.linspace(0, 1, 4) * PLATE_M[1], indexing="ij")
    grid = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    fixed = ((24, "z"), (21, "z"), (14, "z"), (11, "z"))
    stations = np.linspace(1 / 6, 1, 6) * TUBE_M
    wall = np.array([[s, *at] for s in stations for at in ((0.0, RADIUS_M), (RADIUS_M, 0.0))])
    both = tuple((p + 1, axis) for p in range(12) for axis in "yz")
    return {
        "plate": Bench("plate", plate, grid, fixed, tuple(range(1, 25)), (5.0, 260.0), 0.2),
        "tube": Bench("tube", tube, wall, both, (11, 12, 7), (30.0, 780.0), 0.4),
    }


def frf(bench: Bench, of: Matrices, rng: np.random.Generator, built: dict[str, Any]) -> Frf:
    """Accelerances with noise; `built` holds what of the set-up is off: places, gains, forces."""
    omega, vectors = of.modes(MODES)
    out = np.array(
        [of.row(at, axis) @ vectors for at, (_, axis) in zip(built["sensors_m"], bench.sensors, strict=True)]
    )
    into = np.array([of.row(at, "z") @ vectors for at in built["hits_m"]])
    hz = np.arange(bench.band_hz[0], bench.band_hz[1], bench.step_hz)
    s = 2j * np.pi * hz
    kernel = s[:, None] ** 2 / (s[:, None] ** 2 + 2 * built["zeta"] * omega * s[:, None] + omega**2)
    values = ((out[:, None] * into).reshape(-1, MODES) @ kernel.T).reshape(len(out), len(into), -1)
    values *= np.outer(built["gains"], built["forces"])[:, :, None]
    sigma = NOISE * np.sqrt(np.mean(np.abs(values) ** 2, axis=2, keepdims=True))
    noise = rng.standard_normal((2, *values.shape))
    noisy = values + sigma * (noise[0] + 1j * noise[1]) / np.sqrt(2)
    names = tuple(f"a{n + 1:02d}" for n in range(len(bench.sensors)))
    return Frf(hz, noisy, "inertance", names, tuple(p for p, _ in bench.sensors), bench.hits)


def as_believed(bench: Bench) -> dict[str, Any]:
    return {
        "sensors_m": np.array([bench.points[p - 1] for p, _ in bench.sensors]),
        "hits_m": np.array([bench.points[p - 1] for p in bench.hits]),
        "gains": np.ones(len(bench.sensors)),
        "forces": np.ones(len(bench.hits)),
        "zeta": np.full(MODES, ZETA),
    }


def along(bench: Bench, shape: tuple[int, ...], rng: np.random.Generator) -> Real:
    """Deviations of a place along the surface: x and y of a plate, x alone on a tube's wall."""
    moved = rng.standard_normal((*shape, 3))
    moved[..., 2] = 0
    if bench.name == "tube":
        moved[..., 1] = 0
    return moved


def as_built(bench: Bench, rng: np.random.Generator) -> tuple[Matrices, dict[str, Any]]:
    """The bench within its tolerances."""
    t, believed = TOLERANCE, as_believed(bench)
    material = Material(
        1 + t.youngs_modulus * rng.standard_normal(),
        1 + t.density * rng.standard_normal(),
        1 + t.thickness * rng.standard_normal(),
        field(rng, t.stiffness_field),
        field(rng, t.stiffness_field) if bench.name == "plate" else field(rng, 0.0),
        field(rng, t.mass_field),
    )
    of = bench.make(material)
    for at, (_, axis) in zip(believed["sensors_m"], bench.sensors, strict=True):
        row = of.row(at, axis)
        of = Matrices(
            of.mass + abs(t.sensor_mass_kg * rng.standard_normal()) * np.outer(row, row), of.stiffness, of.row
        )
    sensors, hits = len(bench.sensors), len(bench.hits)
    struck = t.hit_position_m * along(bench, (HITS, hits), rng).mean(axis=0)
    force = 1 / (1 + 0.5 * t.sensitivity * rng.standard_normal())
    return of, {
        "sensors_m": believed["sensors_m"] + t.position_m * along(bench, (sensors,), rng),
        "hits_m": np.clip(believed["hits_m"] + struck, -1, [*bench.points.max(axis=0)]),
        "gains": 1 + t.sensitivity * rng.standard_normal(sensors),
        "forces": force * (1 + t.hit_gain * rng.standard_normal((HITS, hits)).mean(axis=0)),
        "zeta": ZETA * np.exp(0.3 * rng.standard_normal(MODES)),
    }


def drawn(bench: Bench, kind: str, rng: np.random.Generator) -> dict[str, Any]:
    """What is wrong, large enough to matter."""
    if kind in ("added_mass", "ground_spring"):
        if bench.name == "plate":
            at = np.array([rng.uniform(0.3, 1) * PLATE_M[0], rng.uniform(0, 1) * PLATE_M[1], 0.0])
            size = 2.6 * rng.uniform(0.01, 0.06) if kind == "added_mass" else 10 ** rng.uniform(2.3, 4.0)
        else:
            side = [(0.0, RADIUS_M), (RADIUS_M, 0.0)][rng.integers(2)]
            at = np.array([rng.uniform(0.3, 1) * TUBE_M, *side])
            size = 5.9 * rng.uniform(0.01, 0.06) if kind == "added_mass" else 10 ** rng.uniform(4.3, 6.0)
        return {"effect": kind, "at_m": at.tolist(), "size": float(size)}
    channel = int(rng.integers(len(bench.sensors)))
    if kind == "gain_error":
        gain = float(np.exp(rng.choice([-1, 1]) * rng.uniform(0.06, 0.5)))
        return {"effect": kind, "channel": f"a{channel + 1:02d}", "size": gain}
    if bench.name == "tube":
        # At the root's ring and where a mode's shape is level a place says nothing.
        moved = np.array([rng.choice([-1, 1]) * rng.uniform(0.02, 0.08), 0.0, 0.0])
    else:
        angle, far = rng.uniform(0, 2 * np.pi), rng.uniform(0.012, 0.05)
        moved = far * np.array([np.cos(angle), np.sin(angle), 0.0])
    moved = _on_it(bench, channel, moved)
    return {
        "effect": kind,
        "channel": f"a{channel + 1:02d}",
        "moved_m": moved.tolist(),
        "size": float(np.linalg.norm(moved)),
    }


def _on_it(bench: Bench, channel: int, moved: Real) -> Real:
    """The move turned back along each axis in which the sensor would leave the structure: it stands on it somewhere."""
    there = bench.points[bench.sensors[channel][0] - 1] + moved
    most = np.array([*PLATE_M, 0.0]) if bench.name == "plate" else np.array([TUBE_M, RADIUS_M, RADIUS_M])
    return np.where((there < 0) | (there > most + 1e-12), -moved, moved)


def put_in(bench: Bench, truth: dict[str, Any], of: Matrices, built: dict[str, Any]) -> tuple[Matrices, dict[str, Any]]:
    """The bench with what is wrong."""
    kind = truth["effect"]
    if kind == "added_mass":
        return with_mass(of, np.array(truth["at_m"]), truth["size"]), built
    if kind == "ground_spring":
        return with_spring(of, np.array(truth["at_m"]), "z", truth["size"]), built
    channel = int(truth["channel"][1:]) - 1
    if kind == "gain_error":
        gains = built["gains"].copy()
        gains[channel] *= truth["size"]
        return of, built | {"gains": gains}
    places = built["sensors_m"].copy()
    places[channel] += truth["moved_m"]
    return of, built | {"sensors_m": places}


def computed(bench: Bench, now: ModalModel) -> tuple[ModalModel, Mesh | None]:
    """The structure's model itself as the simulation, as if a finite-element program had written its modes."""
    omega, vectors = bench.make(Material()).modes(MODES)
    row = bench.make(Material()).row
    nodes = np.concatenate([bench.points, mesh(bench)])
    at = {n + 1: np.array([row(place, axis) @ vectors for axis in "xyz"]).T for n, place in enumerate(nodes)}
    places = {n + 1: tuple(place) for n, place in enumerate(nodes.tolist())}
    modes = NodeModes(bench.name, omega / (2 * np.pi), at, places, np.full(MODES, ZETA))
    how = (FemModel(modes, {}), bench.rig, now.band_hz, bench.hits)
    return model_of_elements(*how), mesh_shapes(*how)


def mesh(bench: Bench) -> Real:
    """(nodes, 3) as a mesher lays them: some 25 mm apart on the plate, 24 around the tube."""
    if bench.name == "plate":
        x, y = np.meshgrid(np.linspace(0, 1, 25) * PLATE_M[0], np.linspace(0, 1, 17) * PLATE_M[1], indexing="ij")
        return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    x, angle = np.meshgrid(np.linspace(0, 1, 49) * TUBE_M, np.arange(24) * np.pi / 12, indexing="ij")
    return np.stack([x.ravel(), RADIUS_M * np.cos(angle).ravel(), RADIUS_M * np.sin(angle).ravel()], axis=1)


def trial(bench: Bench, kind: str, seed: int, *, elements: bool = False) -> dict[str, Any]:
    """One trial: truth and diagnosis."""
    rng = np.random.default_rng([seed, 17])
    rig = bench.rig
    reference, _ = identify_frf(
        frf(bench, bench.make(Material()), rng, as_believed(bench)), rig, IdentificationOptions()
    )
    of, built = as_built(bench, rng)
    truth: dict[str, Any] = {"effect": "none"}
    if kind != "none":
        truth = drawn(bench, kind, rng)
        of, built = put_in(bench, truth, of, built)
    now, _ = identify_frf(frf(bench, of, rng, built), rig, IdentificationOptions())
    known = None
    if elements:
        reference, known = computed(bench, now)
    begun = time.process_time()
    found = diagnose_by_model(reference, now, rig, known)
    took = time.process_time() - begun
    modes = [reference.n_modes, now.n_modes]
    return {"bench": bench.name, "seed": seed, "truth": truth, "modes": modes, "seconds": took} | {
        "said": found.model_dump(mode="json")
    }


def judged(entry: dict[str, Any]) -> dict[str, Any]:
    """Whether verdict, place and number are right."""
    truth, said = entry["truth"], entry["said"]
    effects = said["effects"]
    if truth["effect"] == "none":
        return {"right": said["verdict"] == "no_gap"}
    first = effects[0] if effects else None
    right = said["verdict"] == "known" and len(effects) == 1 and first["effect"] == truth["effect"]
    if not right:
        return {"right": False}
    values = list(first["parameters"].values())
    if "at_m" in truth:
        size = PLATE_M[0] if entry["bench"] == "plate" else TUBE_M
        off = np.linalg.norm(np.array(first["place"]["at_m"]) - truth["at_m"]) / size
        return {
            "right": True,
            "place": bool(off < 0.05),
            "off": float(off),
            "error": abs(values[0] / truth["size"] - 1),
        }
    size = truth["size"]
    if truth["effect"] == "gain_error":
        return {
            "right": True,
            "place": first["place"]["channel"] == truth["channel"],
            "error": abs(values[0] / size - 1),
        }
    moved = np.array([first["parameters"][k] for k in ("dx", "dy", "dz")])
    error = float(np.linalg.norm(moved - truth["moved_m"]) / size)
    return {"right": True, "place": first["place"]["channel"] == truth["channel"], "error": error}


def printed(entry: dict[str, Any]) -> str:
    mark, said, truth = judged(entry), entry["said"], entry["truth"]
    words = "+".join(e["effect"] for e in said["effects"]) or said["verdict"]
    off = f"place {mark['place']} error {100 * mark['error']:.2g} %" if "error" in mark else ""
    strain = f"strain {said['strain_before']:.2f} to {said['strain_after']:.2f}"
    left = f"{said['nominal']:.3f} {said['before']:.4f} {said['after']:.4f}"
    true = {k: v for k, v in truth.items() if k != "effect"}
    right = "right" if mark["right"] else "WRONG"
    return (
        f"{entry['bench']:5s} {entry['seed']:5d} {right} {truth['effect']:14s} -> {words:16s} {off} | {strain}, {left}"
        f" | modes {entry['modes']} | {entry['seconds']:.1f} s {true}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=60, help="with one change each, benches and kinds in turn")
    parser.add_argument("--none", type=int, default=0, help="without any")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bench", choices=("plate", "tube"))
    parser.add_argument("--elements", action="store_true", help="the simulation is computed, not identified")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--score", type=Path)
    a = parser.parse_args()
    every = [b for name, b in benches().items() if a.bench in (None, name)]
    listed = [(every[n % len(every)], KINDS[(n // len(every)) % 4], a.seed * 1000 + n) for n in range(a.trials)]
    listed += [(every[n % len(every)], "none", a.seed * 1000 + 500 + n) for n in range(a.none)]
    entries: list[dict[str, Any]] = []
    if a.score is not None:
        entries = [json.loads(line) for line in a.score.read_text().splitlines()]
        print("\n".join(map(printed, entries)))
    else:
        for bench, kind, seed in listed:
            entries.append(trial(bench, kind, seed, elements=a.elements))
            print(printed(entries[-1]), flush=True)
            if a.out is not None:
                with a.out.open("a") as target:
                    target.write(json.dumps(entries[-1]) + "\n")
    summed_up(entries)


def summed_up(entries: list[dict[str, Any]]) -> None:
    marks = [(e["truth"]["effect"], judged(e)) for e in entries]
    for kind in (*KINDS, "none"):
        _print_row(kind, [m for k, m in marks if k == kind])
    _print_row("all single", [m for k, m in marks if k != "none"])
    seconds = [e["seconds"] for e in entries]
    if seconds:
        print(f"processor seconds: median {np.median(seconds):.1f}, worst {max(seconds):.1f}")


def _print_row(name: str, of: list[dict[str, Any]]) -> None:
    if not of:
        return
    errors = [100 * m["error"] for m in of if "error" in m] or [float("nan")]
    places = [m["place"] for m in of if "place" in m]
    said = f"right {sum(m['right'] for m in of)} of {len(of)}, place {sum(places)} of {len(places)}"
    print(f"{name}: {said}, number off by {np.median(errors):.2g} % (median), {max(errors):.2g} % (worst)")


if __name__ == "__main__":
    main()
