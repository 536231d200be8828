"""A modal system in closed form, sampled without any integrator: the oracle of the identification tests.

Written apart from the code under test: responses are sums of analytic convolutions of a piecewise polynomial hit with
damped sines, done at a high rate by exact recursion, and then decimated in the frequency domain.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block
from modallab.core.rig import Channel, Point, Rig


@dataclass(frozen=True)
class Modes:
    frequency_hz: NDArray[np.float64]
    zeta: NDArray[np.float64]
    phi: NDArray[np.float64]  # (modes, points) at unit modal mass


def modes(rng: np.random.Generator, n_modes: int = 3, n_points: int = 5, first_hz: float = 6.3) -> Modes:
    order = np.arange(1, n_modes + 1)
    frequency = first_hz * (2 * order - 1) ** 2 * rng.uniform(0.97, 1.03, n_modes)
    x = np.linspace(0.2, 1.0, n_points)
    phi = np.sin(np.outer((2 * order - 1) * np.pi / 2, x)) * rng.uniform(0.8, 1.5, (n_modes, 1))
    return Modes(frequency, rng.uniform(0.003, 0.01, n_modes), phi)


def rig(n_points: int) -> Rig:
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [
        Channel(index=i, name=f"a{i:02d}", quantity="acceleration", unit="m/s^2", point=i)
        for i in range(1, n_points + 1)
    ]
    points = tuple(Point(id=i, x_m=0.1 * i) for i in range(1, n_points + 1))
    return Rig(name="closed form", model="unknown", points=points, channels=tuple(channels))


def lowpass(values: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """Band-limit to 0.45 of the low rate and decimate: a linear-phase anti-alias filter with no delay."""
    n = values.shape[-1]
    spectrum = np.fft.rfft(values, 2 * n)
    share = np.arange(spectrum.shape[-1]) / spectrum.shape[-1] * factor
    window = 0.5 * (1 + np.cos(np.pi * np.clip((share - 0.85) / 0.1, 0, 1)))
    return np.fft.irfft(spectrum * window, 2 * n)[..., :n:factor]


def respond(system: Modes, force: NDArray[np.float64], drive: int, rate_hz: float) -> NDArray[np.float64]:
    """Acceleration (points, n) from rest, the force held linearly between samples: exact for such a force."""
    dt = 1 / rate_hz
    out = np.zeros((system.phi.shape[1], force.size))
    for f, zeta, phi in zip(system.frequency_hz, system.zeta, system.phi, strict=True):
        w0 = 2 * np.pi * f
        pole = -zeta * w0 + 1j * w0 * np.sqrt(1 - zeta**2)
        z = np.exp(pole * dt)
        # q' = pole q + force / (2 j omega_d), first-order hold (exact integrals of the exponential).
        e1 = (z - 1) / pole
        e2 = (e1 - dt) / pole / dt
        now, later = (e1 - e2) / (2j * pole.imag), e2 / (2j * pole.imag)
        drive_term = np.concatenate([[0], now * force[:-1] + later * force[1:]])
        from scipy.signal import lfilter

        q = lfilter([1.0], [1.0, -z], drive_term)
        acceleration = 2 * np.real(pole**2 * q + pole * force / (2j * pole.imag))
        out += phi[:, None] * phi[drive - 1] * acceleration
    return out


def pulse(n: int, rate_hz: float, at_s: float, width_s: float, peak_n: float) -> NDArray[np.float64]:
    t = np.arange(n) / rate_hz - at_s
    return peak_n * np.where(np.abs(t) < width_s / 2, np.cos(np.pi * t / width_s) ** 2, 0.0)


def impact_blocks(
    system: Modes,
    rng: np.random.Generator,
    *,
    points: tuple[int, ...] = (5,),
    hits: int = 5,
    noise: float = 0.03,
    force_noise: float = 0.015,
    rate_hz: float = 2000.0,
    n: int = 2048,
    rest: float = 0.0,
) -> list[Block]:
    factor = 16
    blocks = []
    for point in points:
        for hit in range(hits):
            at, width = 0.05 + rng.uniform(0, 5e-4), rng.uniform(3e-3, 5e-3)
            # Longer than the block: the filter must not see the block's end as a step.
            force = pulse((n + 256) * factor, rate_hz * factor, at, width, rng.uniform(60, 120))
            both = np.vstack([force, respond(system, force, point, rate_hz * factor)])
            samples = lowpass(both, factor)[:, :n]
            if rest:
                samples[1:] += _ringing(system, rng, rest, n, rate_hz)
            samples[0] += force_noise * rng.standard_normal(n)
            samples[1:] += noise * rng.standard_normal((len(samples) - 1, n))
            blocks.append(block(f"impact_p{point:02d}_{hit + 1}", "impact", len(blocks), rate_hz, samples, point))
    return blocks


def _ringing(system: Modes, rng: np.random.Generator, size: float, n: int, rate_hz: float) -> NDArray[np.float64]:
    t = np.arange(n) / rate_hz
    w0 = 2 * np.pi * system.frequency_hz[0]
    decay = np.exp(-system.zeta[0] * w0 * t) * np.cos(w0 * np.sqrt(1 - system.zeta[0] ** 2) * t + rng.uniform(0, 6.28))
    return size * system.phi[0][:, None] * decay


def sine_blocks(
    system: Modes,
    rng: np.random.Generator,
    frequencies: NDArray[np.float64],
    *,
    point: int = 3,
    noise: float = 0.003,
    force_noise: float = 0.0006,
    rate_hz: float = 1000.0,
    n: int = 1024,
    settle_s: float = 8.0,
) -> list[Block]:
    factor = 8
    fast = rate_hz * factor
    start = int(settle_s * rate_hz)
    t = np.arange((start + n) * factor) / fast
    blocks = []
    for frequency in frequencies:
        ramp = np.clip(t, 0, 1)
        force = 0.5 * (1 - np.cos(np.pi * ramp)) / 2 * np.sin(2 * np.pi * frequency * t)
        # At 8 kHz a sine below 110 Hz is straight between samples to 1e-3 of 1e-3.
        both = np.vstack([force, respond(system, force, point, fast)])[:, start * factor :: factor]
        both[0] += force_noise * rng.standard_normal(n)
        both[1:] += noise * rng.standard_normal((len(both) - 1, n))
        blocks.append(
            block(f"sine_{frequency:07.3f}", "sine", len(blocks), rate_hz, both, point, frequency_hz=float(frequency))
        )
    return blocks


def block(name, test, order, rate_hz, samples, point, frequency_hz=None) -> Block:
    channels = ("force", *(f"a{i:02d}" for i in range(1, len(samples))))
    return Block(
        name=name,
        test=test,
        order=order,
        rate_hz=rate_hz,
        samples=samples,
        scale=np.ones(len(samples)),
        units=("N", *["m/s^2"] * (len(samples) - 1)),
        channels=channels,
        drive_point=point,
        frequency_hz=frequency_hz,
        level="low" if test == "sine" else None,
    )
