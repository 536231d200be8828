"""How stiff a joint at the root may be, where what the beam's higher modes give way there stands in series with it.

A moment of the joint turns the root by the modes that are followed, and at once by all others. The latter is as a
spring in series: it takes 1 / k of the joint's compliance over, and the records see the sum. A bench has all of them, a
simulation as many as it was given.
"""

from modallab.gap.model.fit import Fit
from modallab.twin.bench import Twin
from modallab.twin.elements import slope_rows
from modallab.twin.modes import solve

HIDDEN = "a joint this stiff does not show beside what the higher modes of the beam give way"


def behind(fit: Fit, within: tuple[float, float]) -> tuple[float, float] | None:
    """The interval of a joint's stiffness in N m/rad whether none or all of the higher modes give way there.

    Args:
        fit: of the effect.
        within: the interval if as much of them does as in the fit.

    Returns:
        the wider interval; None where it has no upper end.
    """
    twin = fit.problem.twin(fit.u)
    softest, stiffest = (in_series(twin, k, share) for k, share in zip(within, (0.0, 1.0), strict=True))
    return None if softest is None or stiffest is None else (softest, stiffest)


def in_series(twin: Twin, stiffness: float, share: float) -> float | None:
    """The stiffness in N m/rad that a joint must have to act as it does in a twin if another share of what the higher
    modes give way counts; None where no joint is stiff enough.

    Args:
        twin: with the share that it has, below none or above all as none or all.
        stiffness: of its joint, N m/rad.
        share: the other one.
    """
    slope = slope_rows(0.0, twin.structure.length_m)[0]
    gives_way = float(slope @ solve(twin.structure).out_of_band @ slope)
    own = min(max(twin.residual_compliance, 0.0), 1.0)
    left = 1 / stiffness + gives_way * (own - share)
    return 1 / left if left > 0 else None
