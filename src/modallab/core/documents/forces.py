"""Forces over time by a few numbers: an impulse, a sine, a sweep, random of a spectrum."""

from typing import Annotated, Literal, Self

from pydantic import Field, NonNegativeInt, model_validator

from modallab.core.frozen import Frozen

Newton = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Hertz = Annotated[float, Field(ge=0, le=1e6, allow_inf_nan=False)]
Density = Annotated[float, Field(ge=0, le=1e12, allow_inf_nan=False)]


class ImpulseForce(Frozen):
    """An impulse within one sample, the second.

    Attributes:
        impulse_n_s: time integral of the force.
    """

    kind: Literal["impulse"] = "impulse"
    impulse_n_s: Newton


class SineForce(Frozen):
    """A sine from the first sample on.

    Attributes:
        frequency_hz: of it.
        amplitude_n: of it.
    """

    kind: Literal["sine"] = "sine"
    frequency_hz: Hertz
    amplitude_n: Newton


class SweepForce(Frozen):
    """A sine whose frequency changes evenly over the record.

    Attributes:
        from_hz: frequency at the first sample.
        to_hz: frequency at the last sample.
        amplitude_n: of it.
    """

    kind: Literal["sweep"] = "sweep"
    from_hz: Hertz
    to_hz: Hertz
    amplitude_n: Newton


class RandomForce(Frozen):
    """A random force with a given spectrum.

    Attributes:
        spectrum: ascending frequencies in Hz with one-sided density in N^2/Hz; linear between them, zero outside.
        seed: seed of the random numbers.
    """

    kind: Literal["random"] = "random"
    spectrum: Annotated[tuple[tuple[Hertz, Density], ...], Field(min_length=2, max_length=10000)]
    seed: NonNegativeInt = 0

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if any(b <= a for (a, _), (b, _) in zip(self.spectrum, self.spectrum[1:], strict=False)):
            raise ValueError("the frequencies of a spectrum rise: sort them, and give each once")
        return self


ForceKind = Annotated[ImpulseForce | SineForce | SweepForce | RandomForce, Field(discriminator="kind")]
