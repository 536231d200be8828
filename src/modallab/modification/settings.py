"""Every number that decides what is left of a structure, each with its meaning, unit, default and reason."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RemainderSettings:
    """Settings of what is left when a measured part is taken away.

    Attributes:
        powers: of s in the residual terms of what is left: what lies below and above the band, and the next one.
            Without the last, the worst FRAC of three pairs of plates was 0.86, with it 0.97; one more changed nothing.
        common: directions in which errors of all values go together, such as that of a sensitivity. With as many as
            the samples have, 61 to 67 % of those plates' frequencies lay in their 95 % interval; with these 72 to 83 %.
        own: of the variance of a value, a pure number: what at least it has for itself. Without any the covariance of
            a few samples is singular.
        widest: deviations of a sample that count. Beyond, a shape goes through zero at the joint, and its sample is off
            by any amount: without a bound the worst FRAC of those plates was 0.90.
        far: by which factor a pole may lie beyond all of both. It then stands for what is out of the band; a wider
            bound gave the same in six times the time.
        steps: of the search that follows, at most. Without a bound the same came out in three times the time.
    """

    powers: tuple[int, ...] = (-2, 0, 2)
    common: int = 20
    own: float = 0.01
    widest: float = 3.0
    far: float = 10.0
    steps: int = 50


DEFAULT = RemainderSettings()
