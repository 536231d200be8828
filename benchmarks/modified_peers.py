"""The same modification, coupling and MAC by modallab, SDynPy and pyYeti, of structures known in closed form.

    python benchmarks/modified_peers.py PEER_PYTHON FILE

PEER_PYTHON is an environment with `sdynpy` and `pyyeti`. modallab sees a modal model alone, the peers see matrices. A
row is a number, and by how much the peer's is off.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HZ = np.linspace(1.0, 60.0, 60)
COLUMNS = ("quantity", "peer", "modallab", "of_the_peer", "relative_difference")

PEER = """
import json, sys
import numpy as np
import sdynpy as sdpy
from pyyeti import ode
given = {name: np.array(value) for name, value in json.load(open(sys.argv[1])).items()}
n, hz = len(given["mass"]), given["hz"]
def system(first, mass):
    at = sdpy.coordinate_array(np.arange(first, first + n), "Z+")
    return sdpy.System(at, mass, given["stiffness"], given["damping"])
heavy = given["mass"] + np.diag(given["added"])
changed = system(1, heavy)
held = sdpy.System.concatenate([system(1, given["mass"]), system(101, heavy)])
pair = sdpy.coordinate_array(np.array([[n, 101]]), np.array([["Z+", "Z+"]]))
coupled = held.substructure_by_coordinate(pair)
here = sdpy.coordinate_array(1, "Z+")
frf = lambda s: s.frequency_response(hz, here, here, displacement_derivative=1)
force = np.zeros((n, hz.size)); force[0] = 1
solved = ode.SolveUnc(heavy, given["damping"], given["stiffness"]).fsolve(force, hz)
out = {
    "sdynpy": {
        "modified_hz": np.sort(changed.eigensolution(complex_modes=False).frequency).tolist(),
        "modified_mobility": np.abs(frf(changed).ordinate.ravel()).tolist(),
        "coupled_mobility": np.abs(frf(coupled).ordinate.ravel()).tolist(),
        "mac": np.asarray(sdpy.correlation.mac(given["one"].T, given["other"].T)).ravel().tolist(),
    },
    "pyyeti": {"modified_mobility": np.abs(solved.v[0]).tolist()},
}
print(json.dumps(out))
"""


def of_modallab(given: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    from chain import BARE, Chain

    from modallab.identification.selection.criteria import mac
    from modallab.modification.attachments import Element
    from modallab.modification.coupled import CouplingToStructure
    from modallab.modification.known import KnownStructure

    added = [Element(n + 1, mass=float(kg)) for n, kg in enumerate(given["added"]) if kg]
    bare = KnownStructure(BARE.model())
    heavy = KnownStructure(Chain(BARE.mass + np.diag(given["added"]), BARE.damping, BARE.stiffness).model())
    n, changed = len(BARE.mass), bare.with_changes(added)
    coupled = bare.with_changes([CouplingToStructure(heavy.structure, [(n, 1)])])

    def mobility(known: KnownStructure) -> np.ndarray:
        return np.abs(known.frf(HZ, [1], [1], "mobility", sigma=False).values[0, 0])

    return {
        "modified_hz": changed.modes.frequency_hz,
        "modified_mobility": mobility(changed),
        "coupled_mobility": mobility(coupled),
        "mac": mac(given["one"], given["other"]).ravel(),
    }


def main(peer: str, out: Path) -> None:
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))
    from chain import BARE

    rng = np.random.default_rng(1)
    added = np.zeros(len(BARE.mass))
    added[2] = 0.4
    given = {
        "mass": BARE.mass, "damping": BARE.damping, "stiffness": BARE.stiffness, "added": added, "hz": HZ,
        "one": rng.standard_normal((4, 7)), "other": rng.standard_normal((3, 7)),
    }  # fmt: skip
    # SDynPy opens a window otherwise.
    bare = os.environ | {"QT_QPA_PLATFORM": "offscreen", "PYTHONPATH": ""}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "given.json"
        path.write_text(json.dumps({name: value.tolist() for name, value in given.items()}))
        said = subprocess.run(
            [peer, "-c", PEER, str(path)], check=True, stdout=subprocess.PIPE, text=True, env=bare
        ).stdout
    theirs, ours = json.loads(said.splitlines()[-1]), of_modallab(given)
    rows = [
        (f"{name}[{n}]", who, own, other, abs(own / other - 1))
        for who, found in theirs.items()
        for name, values in found.items()
        for n, (own, other) in enumerate(zip(ours[name], values, strict=True))
    ]
    with out.open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    for who, found in theirs.items():
        for name in found:
            off = max(r[4] for r in rows if r[0].startswith(f"{name}[") and r[1] == who)
            print(f"{who:8} {name:20} off by {off:.1e} at most")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
