"""Which hits a model's modal constants are of.

Hits at a point are fitted together, and each weighs by the power of its force. One that is short drives the high modes
and one that is long does not, so that the mean place of the hits is another one for each mode.
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.model import ModalModel
from modallab.signals.signals import Signals


def with_hit_shares(model: ModalModel, groups: Sequence[Sequence[Signals]]) -> ModalModel:
    """The model with the share of each hit.

    Args:
        model: of all hits.
        groups: the hits by point, in the order of its inputs.
    """
    omega = 2 * np.pi * model.frequency_hz
    shares = np.zeros((model.n_modes, len(groups), max(map(len, groups))))
    for k, hits in enumerate(groups):
        power = np.array([_power_at(omega, hit) for hit in hits]).T
        shares[:, k, : len(hits)] = power / power.sum(axis=1, keepdims=True)
    return model.model_copy(update={"hit_shares": shares})


def _power_at(omega: np.ndarray, hit: Signals) -> np.ndarray:
    times = np.arange(hit.force.size) / hit.rate_hz
    return np.asarray(np.abs(np.exp(-1j * omega[:, None] * times) @ hit.hit_force) ** 2)
