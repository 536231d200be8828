"""One peer on one case, in the peers' own environment: reads FRFs from a file, prints poles, time and memory as JSON.

    <peers>/bin/python run_peer.py PEER CASE.npz ORDER SECONDS

After so many seconds of processor it is ended.

Each peer is used as its documentation shows. Where it asks its user to pick poles, the true frequencies are given to it
(`requested_hz`), which no user has: what is compared is its estimates, not the picking.
"""

import contextlib
import importlib
import io
import json
import resource
import signal
import sys
import time
from pathlib import Path

import numpy as np


def sdypy(frequency_hz, mobility, requested_hz, order):
    from sdypy import EMA

    model = EMA.Model(
        mobility.reshape(-1, frequency_hz.size),
        frequency_hz,
        lower=max(1.0, 0.5 * requested_hz.min()),
        upper=frequency_hz[-1],
        pol_order_high=order,
        frf_form="mobility",
    )
    model.get_poles(method="lscf", show_progress=False)
    model.select_closest_poles(list(requested_hz), f_window=20)
    return np.asarray(model.nat_freq), np.asarray(model.nat_xi)


def sdynpy(frequency_hz, mobility, requested_hz, order):
    import sdynpy as sdpy
    from sdynpy.modal import PolyPy

    n_out, n_in, _ = mobility.shape
    outputs = sdpy.coordinate_array(np.arange(1, n_out + 1), 3)
    inputs = sdpy.coordinate_array(np.arange(1, n_in + 1) * 1000, 3)
    coordinates = np.stack([np.repeat(outputs[:, None], n_in, axis=1), np.repeat(inputs[None], n_out, axis=0)], axis=-1)
    frfs = sdpy.data_array(sdpy.data.FunctionTypes.FREQUENCY_RESPONSE_FUNCTION, frequency_hz, mobility, coordinates)
    fit = PolyPy(frfs, displacement_derivative=1)
    # Its orders are multiples of the number of inputs.
    fit.compute_poles(np.arange(2, order // n_in + 1) * n_in)
    stable = [p[p["freq_stable"] & p["damp_stable"]] for p in fit.pole_list]
    picked = []
    for requested in requested_hz:
        # The highest order that holds a stable pole there: the list begins with it.
        near = [p[np.argmin(abs(p["omega"] - 2 * np.pi * requested))] for p in stable if p.size]
        near = [p for p in near if abs(p["omega"] / (2 * np.pi * requested) - 1) < 0.01]
        picked.append((near[0]["omega"] / (2 * np.pi), near[0]["zeta"]) if near else (np.nan, np.nan))
    return np.array(picked).T


def pyyeti(frequency_hz, mobility, requested_hz, order):
    from pyyeti import era

    n_lines = frequency_hz.size
    response = np.fft.irfft(mobility, axis=-1)[..., : n_lines // 2]
    rate = 2 * frequency_hz[-1]
    found = era.ERA(
        response.transpose(0, 2, 1),
        sr=rate,
        svd_tol=2 * requested_hz.size,
        auto=True,
        # Left to itself it takes half the record as block rows, and all singular vectors of a matrix of 20480 rows.
        alpha=BLOCK_ROWS,
        # Left to itself it drops what is damped by 0.1 % or less.
        damp_range=(1e-5, 0.5),
        show_plot=False,
        verbose=False,
    )
    return np.asarray(found.freqs_hz), np.asarray(found.zeta)


def pyoma(frequency_hz, mobility, requested_hz, order):
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    n_lines = frequency_hz.size
    # It takes records of the responses alone. Impulse responses of the first input are free decays: their
    # covariances hold the same poles.
    response = np.fft.irfft(mobility[:, 0], axis=-1)[:, : n_lines // 2]
    setup = SingleSetup(response.T, fs=2 * frequency_hz[-1])
    setup.add_algorithms(SSI(name="SSI", method="cov", br=max(10, order // 2), ordmax=order))
    setup.run_by_name("SSI")
    setup.mpe("SSI", sel_freq=list(requested_hz), order_in=order - order % 2)
    found = setup["SSI"].result
    return np.asarray(found.Fn), np.asarray(found.Xi)


BLOCK_ROWS = 256
PEERS = {"sdypy": sdypy, "sdynpy": sdynpy, "pyyeti": pyyeti, "pyoma": pyoma}

MODULES = {
    "sdypy": ("sdypy.EMA",),
    "sdynpy": ("sdynpy.modal",),
    "pyyeti": ("pyyeti.era",),
    "pyoma": ("pyoma2.algorithms", "pyoma2.setup"),
}
"""What each peer imports: before the clock starts, since an import is no identification."""


def peak_mib() -> float:
    """Peak memory of this process. Linux keeps the parent's peak in `ru_maxrss` over a fork, in `VmHWM` it does not."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return next(float(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmHWM")) / 1024


def end_after(seconds: int) -> None:
    """Raises TimeoutError in the peer's code; where that never returns to Python, the process is killed later."""

    def over(number, frame):
        raise TimeoutError(f"ended after {seconds} s of processor")

    if hasattr(signal, "SIGXCPU"):
        signal.signal(signal.SIGXCPU, over)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, 2 * seconds))


def main() -> None:
    name, path, order, limit_s = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    data = np.load(path)
    for module in MODULES[name]:
        importlib.import_module(module)
    end_after(limit_s)
    begin, wall = time.process_time(), time.monotonic()
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            f, zeta = PEERS[name](data["frequency_hz"], data["mobility"], data["requested_hz"], order)
        result = {"f": np.asarray(f, float).tolist(), "zeta": np.asarray(zeta, float).tolist()}
    except Exception as error:  # a peer's failure is a result
        result = {"failed": f"{type(error).__name__}: {error}"[:300]}
    result |= {
        "cpu_s": time.process_time() - begin,
        "wall_s": time.monotonic() - wall,
        "mib": peak_mib(),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
