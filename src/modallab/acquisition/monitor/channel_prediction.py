"""What a channel must read, as the others and the drive say: a regression that is learned while a wave plays.

A structure moves in a few shapes, so each channel is close to a weighted sum of the others and of the drive of the
last few milliseconds. With the second moments M of all of them, the weights for channel c are
-inv(M)[c, j] / inv(M)[c, c], and what they leave unexplained has the variance 1 / inv(M)[c, c] (Lauritzen, Graphical
Models, 1996, section 5.1).
"""

import numpy as np

from modallab.core.arrays import Real


class ChannelPrediction:
    """Learns from stretches, each forgotten little by little, and predicts each channel from the others."""

    def __init__(self, rows: int, forget: float) -> None:
        """For so many rows; `forget` is the part of what is known that each new stretch replaces."""
        self._moments = np.zeros((rows, rows))
        self._count = 0.0
        self._keep = 1 - forget

    @property
    def count(self) -> float:
        """Samples that are known."""
        return self._count

    def learn(self, rows: Real) -> None:
        """Take in (rows, n) samples."""
        self._moments = self._keep * self._moments + rows @ rows.T
        self._count = self._keep * self._count + rows.shape[1]

    def predict(self, rows: Real, channels: int, noise: float) -> tuple[Real, Real]:
        """What (rows, n) samples make the first `channels` read, and the rms that stays unexplained.

        Args:
            rows: channels, then the drive.
            channels: how many of them are predicted.
            noise: rms of each row that explains nothing.
        """
        count = max(self._count, 1.0)
        inverse = np.linalg.inv(self._moments / count + noise**2 * np.eye(len(rows)))
        own = np.diag(inverse)[:channels]
        weights = -inverse[:channels] / own[:, None]
        weights[np.arange(channels), np.arange(channels)] = 0.0
        return weights @ rows, np.sqrt(1 / own)
