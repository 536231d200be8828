"""A bench without noise and with counts too fine to matter: what is left is the effect."""

from importlib.resources import files

import numpy as np

from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.rig import Converter, Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab_simulators.cantilever import open_bench

RATE_HZ = 2000.0


def noiseless_rig() -> Rig:
    path = files("modallab.cli") / "link_rig.yaml"
    rig = parse_rig(path.read_text(encoding="utf-8"), str(path))
    return rig.model_copy(update={"converter": Converter(bits=30, noise_rms_v=0.0)})


def struck(effects: str = "", *, point: int = 10, seconds: float = 6.0, query: str = "seed=1") -> np.ndarray:
    """Volts of all rows from the prompt of a good hit on, (rows, samples)."""
    return _recorded("impact", effects, query, seconds, lambda bench: bench.prompt_hit(point))


def driven(
    effects: str = "", *, f_hz: float = 20.0, volts: float = 1.0, seconds: float = 4.0, query: str = "seed=1"
) -> np.ndarray:
    """Volts of all rows from the beginning of a sine on, at the sine test's preamplifiers, (rows, samples)."""
    burst = Burst(f_hz, volts, 0.2, seconds)
    return _recorded("sine", effects, query, seconds, lambda bench: bench.play(burst))


def resting(effects: str, *, seconds: float = 3.0, query: str = "seed=1") -> np.ndarray:
    """Volts of all rows while nobody excites, (rows, samples)."""
    return _recorded("impact", effects, query, seconds, lambda _: None)


def _recorded(test: str, effects: str, query: str, seconds: float, excite) -> np.ndarray:
    named = "".join(f"&effect={effect}" for effect in effects.split(";") if effect)
    bench = open_bench(f"sim://cantilever?bad_hits=0&{query}{named}", noiseless_rig())
    delivery = bench.configure(AcquisitionRequest(test, RATE_HZ))
    bench.start()
    excite(bench)
    samples = bench.read(round(seconds * RATE_HZ), 1.0).samples * delivery.scale[:, None]
    bench.close()
    return samples


def tone(row: np.ndarray, f_hz: float, rate_hz: float = RATE_HZ) -> complex:
    """Complex amplitude of a sine in a row, by least squares beside a constant."""
    t = np.arange(len(row)) / rate_hz
    basis = np.stack([np.exp(2j * np.pi * f_hz * t).real, np.exp(2j * np.pi * f_hz * t).imag, np.ones_like(t)], axis=1)
    a, b, _ = np.linalg.lstsq(basis, row, rcond=None)[0]
    return complex(a, -b)
