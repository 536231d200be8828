"""Real recordings as FRFs, from folders that their publishers' repositories were cloned to, with the modes they state.

aircraft: github.com/Renkinios/MECA0062-1_vibration_testing (also under VictorRenkin), folder data/sec_lab: a small
aircraft-like structure, struck at 74 points, three accelerometers. Modes: the 13 poles of its src/main.py, from PolyMAX
and a stabilisation diagram. beam1, beam2: github.com/vibrationtoolbox/vibration_toolbox, folder vibration_toolbox/data,
case1.mat and case2.mat: one FRF each. Modes: what the examples of its ema.py print. camera, accelerometer:
github.com/ladisk/ImageBasedModalAnalysisTutorial, folder data: a free beam, hit once, seen by a high-speed camera at 15
points and by an accelerometer. The tutorial's results are not kept with it: modes are the peaks of the accelerometer's
FRF, to its line of 1 Hz.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import io

Real = NDArray[np.float64]
G = 9.80665
AIRCRAFT_POLES = np.array(
    [
        -0.41919794 + 118.39096976j, -1.00311643 + 252.09465353j, -3.0413183 + 551.98202178j,
        -2.06192248 + 563.29930716j, -0.65715752 + 609.91674992j, -0.31543238 + 660.98898914j,
        -3.14291266 + 741.49124913j, -3.11370721 + 786.73446431j, -3.29741211 + 789.05887636j,
        -5.49805437 + 816.49573024j, -7.47931026 + 849.93239504j, -5.91860892 + 900.81265828j,
        -1.41441498 + 1044.67998079j,
    ]
)  # fmt: skip
AIRCRAFT_FILES = (*range(1, 29), *range(31, 59), *range(61, 79))
LVM_HZ, CAMERA_HZ = 50000.0, 15000.0
CAMERA_MODES_HZ = np.array([696.0, 1898.0, 3670.0])
CAMERA_BAND_HZ = (300.0, 4000.0)
SENSORS = ("H1_2", "H1_3", "H1_4")


@dataclass(frozen=True)
class RealSet:
    """FRFs of a recording.

    Attributes:
        frequency_hz: (lines,) without 0 Hz.
        mobility: (outputs, inputs, lines), m/s/N but for a constant factor.
        stated_hz: (modes,) published.
        band_hz: in which everybody looks for them.
    """

    frequency_hz: Real
    mobility: NDArray[np.complex128]
    stated_hz: Real
    band_hz: tuple[float, float]


def aircraft(folder: Path) -> RealSet:
    """74 struck points as outputs, by reciprocity, and the three accelerometers as inputs."""
    found = [io.loadmat(folder / f"DPsv{number:05d}.mat") for number in AIRCRAFT_FILES]
    hz = np.real(found[0]["H1_2"][:, 0])
    inertance = G * np.array([[one[name][:, 1] for name in SENSORS] for one in found], np.complex128)
    return _mobility(hz, inertance, np.abs(AIRCRAFT_POLES) / (2 * np.pi), (10.0, 180.0))


def beam(name: str, stated_hz: tuple[float, ...], band_hz: tuple[float, float]) -> Callable[[Path], RealSet]:
    """One FRF of the vibration toolbox."""

    def read(folder: Path) -> RealSet:
        found = io.loadmat(folder / f"{name}.mat")
        hz, h = np.ravel(found["Freq_domain"]).astype(float), np.ravel(found["Hf_chan_2"])
        return _mobility(hz, h[None, None], np.array(stated_hz), band_hz)

    return read


def camera(folder: Path) -> RealSet:
    """Displacements that a camera saw in 0.25 s, as its tutorial makes FRFs of them: without a window."""
    moved = np.load(folder / "displacements_lk.npy")[..., 0]
    hz = np.fft.rfftfreq(moved.shape[1], 1 / CAMERA_HZ)
    force = np.fft.rfft(_lvm(folder)[: round(moved.shape[1] * LVM_HZ / CAMERA_HZ), 1]) / LVM_HZ
    receptance = np.fft.rfft(moved)[:, : force.size] / CAMERA_HZ / force[: hz.size]
    return _mobility(hz, -((2 * np.pi * hz) ** 2) * receptance[:, None], CAMERA_MODES_HZ, CAMERA_BAND_HZ)


def accelerometer(folder: Path) -> RealSet:
    """What an accelerometer recorded of the same hit in 1 s."""
    volts = _lvm(folder)[:50000]
    inertance = G * np.fft.rfft(volts[:, 0]) / np.fft.rfft(volts[:, 1])
    hz = np.fft.rfftfreq(len(volts), 1 / LVM_HZ)
    return _mobility(hz, inertance[None, None], CAMERA_MODES_HZ, CAMERA_BAND_HZ)


def _lvm(folder: Path) -> Real:
    """(samples, 2) acceleration in g and force in N, written with decimal commas."""
    lines = (folder / "acceleration.lvm").read_text().replace(",", ".").splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("X_Value")) + 1
    return np.array([[float(one) for one in line.split("\t")[1:3]] for line in lines[first:] if line.count("\t") > 1])


def _mobility(hz: Real, inertance: NDArray[np.complex128], stated_hz: Real, band_hz: tuple[float, float]) -> RealSet:
    inside = (hz > 0) & (hz <= band_hz[1])
    return RealSet(hz[inside], inertance[..., inside] / (2j * np.pi * hz[inside]), stated_hz, band_hz)


SETS: dict[str, Callable[[Path], RealSet]] = {
    "aircraft": aircraft,
    "camera": camera,
    "accelerometer": accelerometer,
    "beam1": beam("case1", (212.0925,), (20.0, 480.0)),
    "beam2": beam("case2", (192.5938,), (20.0, 480.0)),
}
