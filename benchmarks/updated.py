"""Beams, plates and tubes with two to five wrong parameters: what a test of each says of them.

    python benchmarks/updated.py 20 benchmarks/results/updated.csv

The structure has what no parameter stands for: stiffness and mass that vary along it, sensors off their points and
sensitivities. One parameter of each model moves nothing that is measured. A row is a parameter.
"""

import csv
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "gap"))

import structures

from modallab.core.model import ModalModel
from modallab.core.rig import Beam, Channel, Point, Rig, Tolerance
from modallab.formats.fem.matrix_model import MatrixModel
from modallab.modification.known import KnownStructure
from modallab.pipelines.model_update import update_model
from modallab.twin.elements import ELEMENTS, beam_matrices, shape_rows
from modallab.twin.matrices import OWN
from modallab.twin.modes import undamped_modes
from modallab.twin.structure import TwinStructure
from modallab.updating.result import Prior, UpdatedParameters

Predict = Callable[[Mapping[str, float]], tuple[np.ndarray, np.ndarray]]
FIRST_SEED = 9301
HZ_SIGMA = 5e-5
COLUMNS = (
    "seed", "structure", "parameter", "believed", "true", "found", "low", "high", "inside", "moves_something",
    "determined", "held_out_before_pct", "held_out_after_pct",
)  # fmt: skip
TOLERANCE = Tolerance.usual()
BEAM = Beam(length_m=0.777, width_m=0.05, thickness_m=0.004, youngs_modulus_pa=205e9, density_kg_m3=7850)


def rig_of(places: np.ndarray, axes: str, beam: Beam | None = None) -> Rig:
    force = Channel(index=0, name="force", quantity="force", unit="N")
    sensors = (
        Channel(index=n, name=f"a{n}", quantity="acceleration", unit="m/s^2", point=p, direction=f"+{axis}")
        for n, (p, axis) in enumerate(((p, a) for p in range(1, len(places) + 1) for a in axes), 1)
    )
    points = tuple(Point(id=n, x_m=x, y_m=y, z_m=z) for n, (x, y, z) in enumerate(places.tolist(), 1))
    name = "beam" if beam else "unknown"
    return Rig(
        name="bench", model="cantilever" if beam else name, beam=beam, tolerance=TOLERANCE, points=points,
        channels=(force, *sensors),
    )  # fmt: skip


def measured(rig: Rig, hz: np.ndarray, phi: np.ndarray, band_hz: float, rng: np.random.Generator) -> ModalModel:
    """As it is identified from shapes (modes, outputs); the last output is the driving point."""
    hz = hz[hz < band_hz] * (1 + TOLERANCE.stiffness_drift / 2 * rng.standard_normal())
    hz = hz * (1 + HZ_SIGMA * rng.standard_normal(hz.size))
    phi = phi[: hz.size]
    gain = 1 + TOLERANCE.sensitivity * rng.standard_normal(phi.shape[1])
    force = 1 + TOLERANCE.sensitivity / 2 * rng.standard_normal() + TOLERANCE.hit_gain * rng.standard_normal()
    constants = (phi * gain * force)[:, :, None] * phi[:, None, -1:]
    sigma = 2e-3 * np.sqrt(np.mean(np.abs(constants) ** 2, axis=1, keepdims=True)) + 0 * constants
    noise = rng.standard_normal((2, *constants.shape))
    nothing, channels = np.full(hz.size, np.nan), rig.channels[1:]
    return ModalModel(
        method="plscf", band_hz=(3.0, band_hz), frequency_hz=hz, damping_ratio=np.full(hz.size, 0.004),
        frequency_sigma_hz=HZ_SIGMA * hz, damping_sigma=np.full(hz.size, 1e-5),
        outputs=tuple(c.name for c in channels), output_points=tuple(c.point for c in channels),
        input_points=(channels[-1].point,),
        modal_constants=constants + sigma / np.sqrt(2) * (noise[0] + 1j * noise[1]), modal_constant_sigma=sigma,
        residuals=np.zeros((0, *constants.shape[1:])), half_power=nothing, half_power_floor=nothing,
    )  # fmt: skip


def moved(places: np.ndarray, rng: np.random.Generator, along: int) -> np.ndarray:
    off = np.zeros(places.shape)
    off[:, :along] = TOLERANCE.position_m * rng.standard_normal((len(places), along))
    return np.minimum(places + off, places.max(axis=0))


def drawn(priors: Mapping[str, Prior], rng: np.random.Generator) -> dict[str, float]:
    """Two to five parameters that are wrong, the others as believed."""
    wrong = rng.choice(list(priors), min(int(rng.integers(2, 6)), len(priors)), replace=False)
    true = {n: float(p.at(rng.standard_normal() if n in wrong else 0.0)) for n, p in priors.items()}
    # No structure has less mass than none, nor falls over.
    return {n: abs(v) if "mass" in n or "spring" in n else v for n, v in true.items()}


def beam(rng: np.random.Generator) -> tuple[KnownStructure, None, dict[str, Prior], dict[str, float], str]:
    """The project's own beam, with numbers of the material, a joint, a mass and a spring."""
    x = BEAM.length_m * np.arange(1, 11) / 10
    places = np.stack([x, 0 * x, 0 * x], 1)
    rig = rig_of(places, "z", BEAM)
    joint = BEAM.bending_stiffness_n_m2 / BEAM.length_m
    extra = {
        "joint_rotation": Prior(60 * joint, 0.6, True), "mass@7": Prior(0, 0.02), "spring@10": Prior(0, 300.0),
        "density": Prior(BEAM.density_kg_m3, 0.01, True), "youngs_modulus": Prior(BEAM.youngs_modulus_pa, 0.03, True),
        "thickness": Prior(BEAM.thickness_m, 1e-6, True),
    }  # fmt: skip
    true = drawn(extra, rng)
    s = TwinStructure.of(BEAM, 0.004)
    s = replace(
        s, youngs_modulus_pa=true["youngs_modulus"], density_kg_m3=true["density"], thickness_m=true["thickness"],
        masses=((x[6], true["mass@7"]),), springs=((x[9], true["spring@10"]),),
        ei_field=TOLERANCE.stiffness_field * rng.standard_normal(3),
        mass_field=TOLERANCE.mass_field * rng.standard_normal(3),
    )  # fmt: skip
    s = replace(s, root_rotation=s.bending_stiffness / (s.length_m * true["joint_rotation"]))
    omega, phi, _ = undamped_modes(s)
    seen = (shape_rows(moved(places, rng, 1)[:, 0], BEAM.length_m) @ phi[:OWN]).T
    return KnownStructure(measured(rig, omega / 2 / np.pi, seen, 900.0, rng), rig), None, extra, true, "thickness"


def segments(rng: np.random.Generator) -> tuple[KnownStructure, MatrixModel, dict[str, Prior], dict[str, float], str]:
    """The beam as matrices: the stiffness of four parts of it, a spring, and a spring that no mode feels."""
    pattern, nodes = beam_matrices(BEAM.length_m), np.arange(1, ELEMENTS + 1)
    ei, rho_a = BEAM.bending_stiffness_n_m2, BEAM.mass_kg / BEAM.length_m
    keep = np.ix_(range(2, OWN), range(2, OWN))
    whole, heavy = ei * pattern.stiffness[0], rho_a * pattern.mass[0]
    parts = {f"EI part {k + 1}": part(whole, k)[keep] for k in range(4)}
    spring, at_clamp = np.zeros((OWN, OWN)), np.zeros((OWN, OWN))
    spring[-2, -2] = at_clamp[2, 2] = 1.0
    by = parts | {"tip spring": spring[keep], "root spring": at_clamp[keep]}
    rows = [(int(n), d) for n in nodes for d in ("z", "ry")]
    at = {int(n): (float(BEAM.length_m * n / ELEMENTS), 0.0, 0.0) for n in nodes}
    model = MatrixModel(whole[keep], heavy[keep], rows, stiffness_slopes=by, places=at)
    priors = {n: Prior(0, 0.05) for n in parts} | {"tip spring": Prior(0, 300.0), "root spring": Prior(0, 300.0)}
    priors |= {"stiffness": Prior(1, 1e-3, True), "mass": Prior(1, 0.01, True)}
    true = drawn(priors, rng)
    x = BEAM.length_m * np.arange(1, 11) / 10
    places = np.stack([x, 0 * x, 0 * x], 1)
    rig = rig_of(places, "z")
    field = TOLERANCE.stiffness_field * rng.standard_normal(3)
    uneven = ei * np.einsum("t,tij->ij", field, pattern.stiffness[1:])[keep]
    there = replace(model, stiffness=model.stiffness + uneven).modes(true)
    full = np.array([[0.0, 0.0]] * there.frequency_hz.size)
    columns = np.stack([there.at[int(n)][:, 2] for n in nodes], 1)
    seen = np.concatenate([full[:, :1], columns], axis=1)
    grid = np.linspace(0, BEAM.length_m, ELEMENTS + 1)
    phi = np.array([np.interp(moved(places, rng, 1)[:, 0], grid, one) for one in seen])
    return KnownStructure(measured(rig, there.frequency_hz, phi, 900.0, rng), rig), model, priors, true, "root spring"


def part(whole: np.ndarray, k: int) -> np.ndarray:
    """The stiffness of one quarter of the elements."""
    each, found = ELEMENTS // 4, np.zeros_like(whole)
    one = element(whole)
    for e in range(k * each, (k + 1) * each):
        found[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += one
    return found


def element(whole: np.ndarray) -> np.ndarray:
    """Of a uniform beam the matrix of one element: the first block but for what its neighbour adds."""
    one = whole[:4, :4].copy()
    one[2:, 2:] = whole[-2:, -2:]
    return one


def ritz(
    kind: str, rng: np.random.Generator
) -> tuple[KnownStructure, Predict, dict[str, Prior], dict[str, float], str]:
    """A plate or a tube as a Python function."""
    make, axes, along = {"plate": (structures.plate, "z", 2), "tube": (structures.tube, "yz", 1)}[kind]
    places = plate_places() if kind == "plate" else tube_places()
    rig, drive = rig_of(places, axes), "z"
    free = [(p, a) for p in range(len(places)) for a in axes]
    tip, middle = places[-1], places[len(places) // 2]

    def modes(numbers: Mapping[str, float], at: np.ndarray, **uneven: object) -> tuple[np.ndarray, np.ndarray]:
        material = structures.Material(numbers["youngs"], numbers["density"], numbers["thickness"], **uneven)  # pyright: ignore[reportArgumentType]
        m = make(material)
        row = {name: m.row(place, drive) for name, place in (("tip", tip), ("middle", middle))}
        stiffness = m.stiffness + numbers["tip spring"] * np.outer(row["tip"], row["tip"])
        mass = m.mass + numbers["middle mass"] * sum(
            np.outer(m.row(middle, a), m.row(middle, a)) for a in ("xyz" if kind == "tube" else "z")
        )
        omega, vectors = replace(m, mass=mass, stiffness=stiffness).modes(14)
        rows = np.array([m.row(at[p], a) for p, a in free])
        return omega / 2 / np.pi, (rows @ vectors).T

    whole = make(structures.Material())
    first, heavy = whole.modes(1)[0][0], 1 / np.max(np.abs((whole.row(tip, drive) @ whole.modes(1)[1]) ** 2))
    priors = {
        "youngs": Prior(1, 0.03, True), "density": Prior(1, 0.01, True), "thickness": Prior(1, 0.01, True),
        "tip spring": Prior(0, 0.1 * first**2 * heavy), "middle mass": Prior(0, 0.2 * heavy), "paint": Prior(0, 1.0),
    }  # fmt: skip
    true = drawn(priors, rng)
    uneven = {"stiff_x": structures.field(rng, TOLERANCE.stiffness_field), "mass_x": structures.field(rng, 2e-3)}
    hz, phi = modes(true, moved(places, rng, along), **uneven)
    known = KnownStructure(measured(rig, hz, phi, float(hz[9:11].mean()), rng), rig)
    return known, lambda numbers: modes(numbers, places), priors, true, "paint"


def plate_places() -> np.ndarray:
    x, y = np.meshgrid([0.2, 0.4, 0.6], [0.0, 0.13, 0.27, 0.4], indexing="ij")
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)


def tube_places() -> np.ndarray:
    x = np.repeat([0.3, 0.6, 0.9, 1.2], 2)
    angle = np.tile([0.4, 2.2], 4)
    return np.stack([x, structures.RADIUS_M * np.cos(angle), structures.RADIUS_M * np.sin(angle)], 1)


def rows_of(seed: int) -> list[list[object]]:
    rng = np.random.default_rng(seed)
    kind = ("beam", "segments", "plate", "tube")[seed % 4]
    known, of, priors, true, nothing = {"beam": beam, "segments": segments}.get(kind, lambda r: ritz(kind, r))(rng)
    found = update_model(known, of, priors, tuple(range(3, known.model.n_modes + 1, 3)))
    return [row(seed, kind, found, name, true[name], name != nothing) for name in priors]


def row(seed: int, kind: str, found: UpdatedParameters, name: str, true: float, moves: bool) -> list[object]:
    low, high = found.interval[name]
    before, after = (100 * e for e in found.rms_error(found.held_out))
    return [
        seed, kind, name, found.priors[name].value, true, found.numbers[name], low, high, low <= true <= high, moves,
        name not in found.undetermined_parameters, before, after,
    ]  # fmt: skip


def summary(rows: list[list[object]]) -> str:
    c = dict(zip(COLUMNS, zip(*rows, strict=True), strict=True))
    inside, moves, determined = (np.array(c[n], bool) for n in ("inside", "moves_something", "determined"))
    ratio = np.array(c["held_out_before_pct"], float) / np.array(c["held_out_after_pct"], float)
    each = np.array([ratio[np.array(c["seed"]) == s][0] for s in dict.fromkeys(c["seed"])])
    return (
        f"{len(each)} structures, {len(rows)} parameters: {100 * inside.mean():.0f} % inside the 95 % interval "
        f"({100 * inside[determined].mean():.0f} % of the {determined.sum()} determined ones); "
        f"{np.sum(~determined & ~moves)} of {np.sum(~moves)} that move nothing are named; "
        f"held-out modes {np.median(each):.3g} times nearer in the median, {each.min():.3g} at least, "
        f"{np.sum(each >= 3)} of {len(each)} three times"
    )


if __name__ == "__main__":
    count, out = int(sys.argv[1]), Path(sys.argv[2])
    rows: list[list[object]] = []
    for seed in range(FIRST_SEED, FIRST_SEED + count):
        rows += rows_of(seed)
        print(seed, f"{rows[-1][-2]:.3g} % -> {rows[-1][-1]:.3g} %", flush=True)
    with out.open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    print(summary(rows))
