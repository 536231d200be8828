"""What a test still has to record, and under which name."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Target:
    """A hit that is wanted.

    Attributes:
        point: to strike.
        hit: its number at the point, from 1.
        again: how often it was kept before and then dropped.
    """

    point: int
    hit: int
    again: int = 0

    @property
    def name(self) -> str:
        """Name of its record."""
        return f"impact_p{self.point:02d}_{self.hit}" + (f"_again_{self.again}" if self.again else "")


@dataclass(frozen=True, slots=True)
class Step:
    """A burst that is wanted.

    Attributes:
        level: name of the drive level.
        frequency_hz: to drive at.
        again: how often it was recorded before and is to be repeated.
        replaces: name of the record it takes the place of, once it is kept.
    """

    level: str
    frequency_hz: float
    again: int = 0
    replaces: str = ""

    @property
    def name(self) -> str:
        """Name of its record."""
        return block_name(self.level, self.frequency_hz) + (f"_again_{self.again}" if self.again else "")


def block_name(level: str, frequency_hz: float) -> str:
    """Name of a sine record."""
    return f"sine_{level}_{frequency_hz:07.3f}"
