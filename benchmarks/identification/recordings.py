"""Real recordings: the project beside its peers in one run, published modes found, modes besides, and FRAC.

    OPENBLAS_NUM_THREADS=1 python benchmarks/identification/recordings.py --peers FOLDER --set aircraft DATA

FOLDER is what make_peers.py made, DATA the folder of a set (real_sets.py says where it is published). A published
mode is found if an estimate of its own lies within 1 % of it. Peers that ask their user to pick poles are given the
published frequencies, so that they have none besides by construction; modallab and pyYeti pick by themselves. FRAC is
that of FRFs synthesised from everybody's poles with modal constants and two residual terms by least squares, the same
for all (median and worst over the FRFs, in the band).
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from matching import matched
from numpy.typing import NDArray
from printed import printed
from real_sets import SETS, RealSet
from run_peer import peak_mib

from modallab.core.errors import ModallabError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions

HERE = Path(__file__).parent
PEERS = ("sdypy", "sdynpy", "pyyeti", "pyoma")
HEAD = "who        found  besides   FRAC median, worst    worst |f - stated| %    cpu s"
Real = NDArray[np.float64]


def own(of: RealSet) -> dict[str, Any]:
    """The project on a set, as a user would call it."""
    outputs, inputs, _ = of.mobility.shape
    names = [f"v{n + 1:03d}" for n in range(outputs)]
    points = tuple(Point(id=n + 1, x_m=0.01 * n) for n in range(outputs + inputs))
    channels = [
        Channel(index=n + 1, name=name, quantity="velocity", unit="m/s", point=n + 1) for n, name in enumerate(names)
    ]
    force = Channel(index=0, name="force", quantity="force", unit="N")
    rig = Rig(name="recording", model="unknown", points=points, channels=(force, *channels))
    places = tuple(range(1, outputs + 1)), tuple(range(outputs + 1, outputs + inputs + 1))
    frf = Frf(of.frequency_hz, of.mobility, "mobility", tuple(names), *places)
    begin = time.process_time()
    try:
        model, _ = identify_frf(frf, rig, IdentificationOptions(band_hz=of.band_hz))
    except ModallabError as error:
        return {"failed": str(error).splitlines()[0]}
    found: dict[str, Any] = {"f": model.frequency_hz.tolist(), "zeta": model.damping_ratio.tolist()}
    return found | {"cpu_s": time.process_time() - begin, "mib": peak_mib()}


def peer(of: RealSet, python: Path, name: str, order: int, limit_s: int) -> dict[str, Any]:
    """A peer on a set, in its own environment."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "set.npz"
        np.savez(path, frequency_hz=of.frequency_hz, mobility=of.mobility, requested_hz=of.stated_hz)
        script, numbers = str(HERE / "run_peer.py"), (str(order), str(limit_s))
        return printed([str(python), "-I", "-W", "ignore", script, name, str(path), *numbers])


def frac(of: RealSet, f: Real, zeta: Real) -> Real:
    """(outputs inputs,) of what these poles with constants by least squares synthesise, against the measured FRFs."""
    inside = of.frequency_hz >= of.band_hz[0]
    s, omega = 2j * np.pi * of.frequency_hz[inside], 2 * np.pi * f
    pole = -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)
    one, other = s[:, None] / (s[:, None] - pole), s[:, None] / (s[:, None] - pole.conj())
    # Complex modal constants as two real numbers each, and what lies below and above the band.
    columns = np.concatenate([one + other, 1j * (one - other), 1 / s[:, None], s[:, None]], axis=1)
    columns /= np.linalg.norm(columns, axis=0)
    h = of.mobility[..., inside].reshape(-1, s.size).T
    both = np.concatenate([columns.real, columns.imag]), np.concatenate([h.real, h.imag])
    made = columns @ np.linalg.lstsq(*both, rcond=None)[0]
    cross = np.abs(np.sum(made.conj() * h, axis=0)) ** 2
    return cross / (np.sum(np.abs(made) ** 2, axis=0) * np.sum(np.abs(h) ** 2, axis=0))


def line(name: str, of: RealSet, result: dict[str, Any]) -> str:
    if "failed" in result:
        return f"{name:8s} failed: {str(result['failed'])[:160]}"
    f, zeta = (np.asarray(result[key], float) for key in ("f", "zeta"))
    here = np.isfinite(f) & np.isfinite(zeta) & (f >= of.band_hz[0]) & (f <= of.band_hz[1])
    f, zeta = f[here], zeta[here]
    pairs = matched(of.stated_hz, f)
    found = [(mode, near) for mode, near in enumerate(pairs) if near is not None]
    off = [100 * abs(f[near] / of.stated_hz[mode] - 1) for mode, near in found]
    frac_ = frac(of, f, zeta) if f.size else np.zeros(1)
    besides = [round(float(one), 2) for n, one in enumerate(f) if n not in {near for _, near in found}]
    missing = [round(float(of.stated_hz[m]), 2) for m, near in enumerate(pairs) if near is None]
    counts = f"{name:8s} {len(found):3d} of {of.stated_hz.size:2d}  {len(besides):3d}"
    shares = f"{np.median(frac_):9.4f} {frac_.min():9.4f}"
    worst = f"{max(off, default=np.nan):15.3f} {result['cpu_s']:16.2f}"
    return f"{counts} {shares} {worst}   besides {besides} missing {missing}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path)
    parser.add_argument("--set", nargs=2, action="append", required=True, metavar=("NAME", "FOLDER"))
    parser.add_argument("--only", nargs="*", default=PEERS)
    parser.add_argument("--order", type=int, default=60)
    parser.add_argument("--limit", type=int, default=600, help="processor seconds after which a peer is ended")
    a = parser.parse_args()
    for name, folder in a.set:
        of = SETS[name](Path(folder))
        shape = " x ".join(map(str, of.mobility.shape))
        print(
            f"{name}: {shape}, {of.stated_hz.size} published modes, {of.band_hz[0]:g} to {of.band_hz[1]:g} Hz\n{HEAD}"
        )
        print(line("modallab", of, own(of)), flush=True)
        if a.peers is not None:
            python = a.peers / ("Scripts" if sys.platform == "win32" else "bin") / "python"
            for other in a.only:
                print(line(other, of, peer(of, python, other, a.order, a.limit)), flush=True)


if __name__ == "__main__":
    main()
