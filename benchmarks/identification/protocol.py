"""The paper's protocol: time records of 1.024 s with 0.3 mV of noise on every channel, five hits, modes up to 1 kHz.

Responses are exact: each mode's state is carried from one fine sample to the next in closed form under a hit that is
straight between them, band-limited and thinned out to the converter's rate.
"""

import numpy as np
from cases import BETA, cantilever_shapes
from numpy.typing import NDArray
from scipy import signal

from modallab.core.block import Block
from modallab.core.errors import IdentificationError
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.impact import identify_impact
from modallab.identification.options import IdentificationOptions
from modallab.signals.signals import to_signals_of

RATE_HZ, N, FINE = 2000.0, 2048, 16
NOISE_V = 3e-4
FORCE_V_PER_N, ACCELERATION_V_PER_MS2 = 0.02, 0.01
AFTER = 256
"""Samples beyond the block: the filter must not see the block's end as a step."""
MASS_KG = 1.2
TOP_HZ = 1000.0
FIRST_HZ = 4.8


def paper(
    seed: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], ModalModel | None]:
    """True frequencies, damping and shapes inside the default band, and the model found."""
    rng = np.random.default_rng(seed)
    frequency = FIRST_HZ * (BETA / BETA[0]) ** 2 * rng.uniform(0.99, 1.01)
    frequency = frequency[frequency < TOP_HZ]
    zeta = rng.uniform(0.003, 0.01, frequency.size)
    phi = cantilever_shapes(frequency.size, np.arange(1, 11) / 10) / np.sqrt(MASS_KG)
    blocks = [_hit(rng, frequency, zeta, phi, k) for k in range(5)]
    try:
        model, _ = identify_impact(to_signals_of(blocks, _rig()), _rig(), IdentificationOptions())
    except IdentificationError:
        return frequency[:7], zeta[:7], phi[:7], None
    inside = (frequency > model.band_hz[0]) & (frequency < model.band_hz[1])
    return frequency[inside], zeta[inside], phi[inside], model


def _rig() -> Rig:
    channels = [Channel(index=0, name="force", quantity="force", unit="N", sensitivity_v_per_unit=FORCE_V_PER_N)]
    channels += [
        Channel(
            index=i,
            name=f"a{i:02d}",
            quantity="acceleration",
            unit="m/s^2",
            point=i,
            sensitivity_v_per_unit=ACCELERATION_V_PER_MS2,
        )
        for i in range(1, 11)
    ]
    points = tuple(Point(id=i, x_m=0.1 * i) for i in range(1, 11))
    return Rig(name="paper", model="unknown", points=points, channels=tuple(channels))


def _hit(
    rng: np.random.Generator,
    frequency: NDArray[np.float64],
    zeta: NDArray[np.float64],
    phi: NDArray[np.float64],
    number: int,
) -> Block:
    rate = RATE_HZ * FINE
    t = np.arange((N + AFTER) * FINE) / rate - 0.05 - rng.uniform(0, 5e-4)
    width = rng.uniform(2e-3, 3e-3)
    force = rng.uniform(40, 60) * np.where(np.abs(t) < width / 2, np.cos(np.pi * t / width) ** 2, 0)
    accelerations = _thinned(_accelerations(force, frequency, zeta, phi, 1 / rate))
    samples = (
        np.vstack([_thinned(force[None], straight=True), accelerations])
        * np.array([FORCE_V_PER_N, *[ACCELERATION_V_PER_MS2] * 10])[:, None]
    )
    samples += NOISE_V * rng.standard_normal(samples.shape)
    channels = ("force", *(f"a{i:02d}" for i in range(1, 11)))
    return Block(
        f"hit_{number}", "impact", number, RATE_HZ, samples, np.ones(11), ("V",) * 11, channels, drive_point=10
    )


def _accelerations(
    force: NDArray[np.float64],
    frequency: NDArray[np.float64],
    zeta: NDArray[np.float64],
    phi: NDArray[np.float64],
    dt: float,
) -> NDArray[np.float64]:
    total = np.zeros((phi.shape[1], force.size))
    for f, z, shape in zip(frequency, zeta, phi, strict=True):
        w = 2 * np.pi * f
        pole = -z * w + 1j * w * np.sqrt(1 - z**2)
        step = np.exp(pole * dt)
        first = (step - 1) / pole
        second = (first - dt) / pole / dt
        now, later = first - second, second
        # q(t + dt) = e q(t) + int e^(pole (dt - u)) (f0 + (f1 - f0) u / dt) du.
        drive = np.concatenate([[0], now * force[:-1] + later * force[1:]])
        state = signal.lfilter([1.0], [1.0, -step], drive)
        acceleration = np.real((pole**2 * state + pole * force) / (1j * pole.imag))
        total += np.outer(shape * shape[-1], acceleration)
    return total


def _thinned(values: NDArray[np.float64], *, straight: bool = False) -> NDArray[np.float64]:
    """To the converter's rate, through a linear-phase anti-alias filter that is flat to 0.85 of Nyquist.

    `straight` says that the signal is straight between its samples, as the force that drives the modes is: its spectrum
    is that of the samples times sinc^2, 5e-4 less at 400 Hz.
    """
    n = values.shape[-1]
    spectrum = np.fft.rfft(values, 2 * n)
    share = np.arange(spectrum.shape[-1]) / spectrum.shape[-1] * FINE
    window = 0.5 * (1 + np.cos(np.pi * np.clip((share - 0.85) / 0.1, 0, 1)))
    if straight:
        window = window * np.sinc(np.arange(spectrum.shape[-1]) / (2 * n)) ** 2
    return np.fft.irfft(spectrum * window, 2 * n)[..., : N * FINE : FINE]
