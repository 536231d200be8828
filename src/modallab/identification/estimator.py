"""What an estimator declares of itself, and where those there are can be found.

Each module of `modallab.identification.estimators` is one estimator. Its name is that of the file, so that the command
line can offer it without importing any.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from modallab.core.discovery import declaration_in_module, declared_names
from modallab.core.errors import ConfigurationError, IdentificationError

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from modallab.core.frf import Frf
    from modallab.core.model import ModalModel
    from modallab.core.units import Test
    from modallab.identification.start.stabilisation import OrderPoles

USUAL = "plscf"
"""The estimator that is taken where none is named."""

PACKAGE = "modallab.identification.estimators"
"""Where they are declared, one module each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelOrder:
    """The one parameter of an estimator that solves rising orders; the poles that hold over them are taken.

    Attributes:
        meaning: what the order counts, such as "number of states".
        lowest: no order below holds a mode.
        highest: none above is solved.
        default: in words, which order is taken if none is given.
        suits: the order that is taken for these FRFs, at least `lowest`.
        modes: how many modes one more order can hold.
        solve: poles at every order up to the one given, by rising order.
    """

    meaning: str
    lowest: int
    highest: int
    default: str
    suits: Callable[[Frf], int]
    modes: Callable[[Frf], float]
    solve: Callable[[Frf, int], list[OrderPoles]]

    def check(self, order: int) -> None:
        """Reject an order outside the limits.

        Raises:
            IdentificationError: names the order and the limit.
        """
        if order < self.lowest:
            raise IdentificationError(
                f"order {order} holds no mode", remedy=f"ask for an order of at least {self.lowest}"
            )
        if order > self.highest:
            raise IdentificationError(
                f"order {order} is more than can be solved in reasonable time",
                remedy=f"ask for an order of at most {self.highest}",
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimator:
    """An estimator: FRFs in, poles out. It has either an `order` or `poles`.

    Attributes:
        name: that of its file.
        title: as a heading names it, such as "circle fit".
        called: as a sentence names it, such as "the circle fit".
        description: what it does, in one line.
        source: where the method is published.
        grid: lines it takes: "even" are whole multiples of their spacing, "any" need only ascend.
        refined: whether its poles usually begin a maximum-likelihood search.
        damping: whether its poles say anything of the damping; if not, they are always refined.
        order: the order it solves up to, and how.
        poles: poles in rad/s with positive imaginary part of an estimator that has no order.
        model: a modal model of its own, shapes included, which stands for the unrefined result.
    """

    name: str = ""
    title: str = ""
    called: str = ""
    description: str = ""
    source: str = ""
    grid: Literal["even", "any"]
    refined: bool
    damping: bool = True
    order: ModelOrder | None = None
    poles: Callable[[Frf], NDArray[np.complex128]] | None = None
    model: Callable[[Frf, Test | None], ModalModel] | None = None

    def __post_init__(self) -> None:
        """Reject a declaration that lacks something.

        Raises:
            ConfigurationError: says what is missing.
        """
        missing = [n for n in ("name", "title", "called", "description", "source") if not getattr(self, n).strip()]
        missing += ["either an order or poles"] if (self.order is None) == (self.poles is None) else []
        missing += ["a source of damping: its poles have none and are not refined"] * (
            not self.damping and not self.refined
        )
        if self.order is not None and not (2 <= self.order.lowest <= self.order.highest and self.order.default):
            missing.append("limits of its order, from 2 on, and its default in words")
        if missing:
            raise ConfigurationError(
                f"the estimator {self.name!r} does not declare {', '.join(missing)}",
                remedy="complete its declaration; modallab.identification.estimator.Estimator says what each part is",
            )

    @property
    def brings(self) -> tuple[str, ...]:
        """What can be read off its own result: frequency, and perhaps damping and mode shapes."""
        return ("frequency", *(("damping",) if self.damping else ()), *(("mode shapes",) if self.model else ()))


def estimator_names() -> tuple[str, ...]:
    """Names of the estimators there are; none of them is imported."""
    return declared_names(PACKAGE)


def find_estimator(name: str) -> Estimator:
    """The estimator of this name.

    Raises:
        IdentificationError: there is none; names those there are.
        ConfigurationError: its file declares nothing, or not all.
    """
    if name not in estimator_names():
        raise IdentificationError(
            f"there is no estimator {name!r}", remedy=f"ask for one of {', '.join(estimator_names())}"
        )
    return declaration_in_module(PACKAGE, name, "ESTIMATOR", Estimator)


def estimator_of(method: str) -> Estimator | None:
    """The estimator that a stored model names; None if it is not installed here."""
    return find_estimator(method) if method in estimator_names() else None
