"""Numbers of documents that are finite, and above 0 or not below it."""

from typing import Annotated

from pydantic import Field, PositiveFloat

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[PositiveFloat, Field(allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
