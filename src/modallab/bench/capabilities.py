"""What a bench may be able to do besides: each is looked for on the bench itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from modallab.bench.protocol import SampleChunk, Waveform


@dataclass(frozen=True, slots=True)
class ReferenceTrigger:
    """A finite record about the first crossing of a level, found by the device itself.

    Attributes:
        channel: place in the rig.
        level: as the samples are delivered; crossed upwards if positive, downwards if negative.
        hysteresis: how far from the level the signal must have been before, as delivered.
        pre_trigger: samples kept before the crossing.
        count: samples of the record.
    """

    channel: int
    level: float
    hysteresis: float
    pre_trigger: int
    count: int


@runtime_checkable
class TriggersInHardware(Protocol):
    """A bench whose device can wait for a hit by itself. While it does, nothing streams."""

    def arm(self, trigger: ReferenceTrigger) -> None:
        """Begin to wait, while configured or stopped; `stop` ends it. Raises ConfigurationError, DeviceGoneError."""
        ...

    def is_armed(self) -> bool:
        """Whether the pre-trigger is full: what crosses the level before that is ignored by the device."""
        ...

    def triggered(self, timeout_s: float) -> SampleChunk:
        """The record, its first sample counted as 0. Raises BenchTimeoutError: no crossing yet, ask again."""
        ...


@runtime_checkable
class PlaysWaves(Protocol):
    """A bench whose output plays more than sines."""

    def play_wave(self, wave: Waveform) -> int:
        """Start a wave; returns the sample count of its beginning. Raises UnsupportedError, ConfigurationError."""
        ...


@runtime_checkable
class DrivesSeveralShakers(PlaysWaves, Protocol):
    """A bench with an output for each shaker of its rig, which play together and end together.

    `zero` brings all of them to 0 V at once, as their end by themselves and any watchdog does.
    """

    def play_waves(self, waves: Sequence[Waveform]) -> int:
        """Start one wave on each output, the first shaker's first, all at one sample; returns its count.

        Raises:
            UnsupportedError: there are fewer outputs than waves.
            ConfigurationError: something is still on, or a wave is beyond the rig's limits or an output's range.
        """
        ...


@runtime_checkable
class ReportsOutput(Protocol):
    """A bench whose excitation can be asked what it plays."""

    def output_facts(self) -> dict[str, float | str]:
        """What the excitation says it plays, asked now; empty if it cannot be asked.

        Raises:
            OutputLostError: it is not what was set; the output was brought to 0 V.
        """
        ...


@runtime_checkable
class ReadsSensitivities(Protocol):
    """A bench whose sensors may say themselves how sensitive they are (TEDS)."""

    def read_sensitivities(self) -> dict[str, float]:
        """V per SI unit by channel name, for those that say so; only while nothing streams."""
        ...


@runtime_checkable
class SensorSupplyCheck(Protocol):
    """A bench whose device feeds sensors, and may be able to say that one is missing."""

    def channels_without_open_detection(self) -> tuple[str, ...]:
        """Names of fed channels of which the device cannot say whether a sensor is there; known once it was read."""
        ...


@runtime_checkable
class ReadsSerialNumbers(Protocol):
    """A bench whose sensors may say themselves which they are (TEDS)."""

    def read_serials(self) -> dict[str, str]:
        """Serial number by channel name, for those that say so; only while nothing streams."""
        ...


@dataclass(frozen=True, slots=True)
class SyncState:
    """How several devices sample as one.

    Attributes:
        method: in words; empty where one device samples all.
        acquired: samples each device has counted since the start.
        unlocked: inputs whose clock has lost its reference.
    """

    method: str
    acquired: dict[str, int]
    unlocked: tuple[str, ...]


@runtime_checkable
class SynchronisedBench(Protocol):
    """A bench of several devices that sample as one."""

    def synchronisation(self) -> SyncState:
        """What the devices say of it, once configured."""
        ...


@runtime_checkable
class SuppliesSensors(Protocol):
    """A bench whose inputs feed sensors: their bias must settle after the supply comes on."""

    def supplied_channels(self) -> tuple[str, ...]:
        """Names of the channels that it feeds with a current."""
        ...
