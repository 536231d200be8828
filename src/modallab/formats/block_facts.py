"""What a block is besides its samples, as one line of JSON that formats of others carry along in a remark."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.core.units import TESTS, Test
from modallab.formats.options import ImportOptions

MARK = "modallab "
_AGREE = 1e-4
"""Relative difference allowed between the rate in the remark and that of the format's own, rounded field."""


@dataclass(frozen=True, slots=True)
class BlockFacts:
    """As the attributes of `Block`; None or 0 where it has none."""

    name: str
    test: Test
    rate_hz: float
    drive_point: int | None = None
    level: str | None = None
    frequency_hz: float | None = None
    first_sample: int = 0

    @classmethod
    def of(cls, block: Block) -> Self:
        """The facts of a block."""
        return cls(**{name: getattr(block, name) for name in cls.__slots__})

    def block(
        self, samples: NDArray[Any], units: Sequence[str], rig: Rig, *, order: int = 0, scale: Real | None = None
    ) -> Block:
        """The record of these samples.

        Args:
            samples: (channels, n) of the rig's channels, in its order.
            units: (channels,) of the samples after the scale.
            rig: whose channels they are.
            order: place among the records of a campaign.
            scale: (channels,) unit per number; 1 where it is not given.
        """
        return Block(
            samples=samples,
            scale=np.ones(len(samples)) if scale is None else scale,
            units=tuple(units),
            channels=tuple(channel.name for channel in rig.channels),
            order=order,
            **{name: getattr(self, name) for name in self.__slots__},
        )

    def text(self) -> str:
        """A line that `read_facts` understands."""
        content = {name: getattr(self, name) for name in self.__slots__}
        facts = {name: value for name, value in content.items() if value not in (None, 0)}
        # Without blanks, which fields of fixed width lose at their ends.
        return MARK + json.dumps(facts, separators=(",", ":"), allow_nan=False).replace(" ", "\\u0020")


def read_facts(line: str, where: str) -> BlockFacts | None:
    """The facts in a remark; None if it is not one of ours.

    Raises:
        FormatError: it is one of ours, and damaged.
    """
    start = line.find(MARK + "{")
    if start < 0:
        return None
    try:
        content: Any = json.loads(line[start + len(MARK) :].strip())
        return _checked(cast("dict[str, Any]", content))
    except (ValueError, TypeError, KeyError) as error:
        raise FormatError(
            f"the remark {line.strip()!r} is damaged", where=where, remedy="export it again, or remove the remark"
        ) from error


def facts_or_options(facts: BlockFacts | None, name: str, rate_hz: float, options: ImportOptions) -> BlockFacts:
    """The facts of a recording: its own remark with the drive point that the user said, or all as the user said it.

    Raises:
        FormatError: the remark's rate is not that of the times.
    """
    if facts is None:
        return BlockFacts(name, options.test, rate_hz, options.drive_point, frequency_hz=options.frequency_hz)
    if abs(facts.rate_hz - rate_hz) > _AGREE * rate_hz:
        raise FormatError(
            f"its remark says {facts.rate_hz:g} Hz, its times {rate_hz:g} Hz",
            where=name,
            remedy="export it again, or remove the remark",
        )
    return facts if options.drive_point is None else replace(facts, drive_point=options.drive_point)


def _checked(content: dict[str, Any]) -> BlockFacts:
    facts = BlockFacts(**content)
    kinds = ((facts.name, str), (facts.rate_hz, float | int), (facts.drive_point, int | None))
    more = ((facts.level, str | None), (facts.frequency_hz, float | int | None), (facts.first_sample, int))
    if facts.test not in TESTS or not all(isinstance(value, kind) for value, kind in (*kinds, *more)):
        raise ValueError("of another kind")
    return facts
