"""The stiffness of a joint at the root, in series with the compliance of the modes above the band.

A moment of the joint turns the root through the modes that are computed, and without delay through all modes above. The
latter act as a spring in series; the records determine the sum of both compliances. A real beam has infinitely many
such modes, a simulation a given number.
"""

from modallab.gap.model.fit import Fit
from modallab.twin.bench import Twin
from modallab.twin.elements import slope_rows
from modallab.twin.modes import solve_modes

HIDDEN = "a joint this stiff cannot be distinguished from the compliance of the modes above the band"


def interval_in_series(fit: Fit, within: tuple[float, float]) -> tuple[float, float] | None:
    """The interval of a joint's stiffness in N m/rad for none and for all of the compliance of the modes above.

    Args:
        fit: of the effect.
        within: the interval at the compliance that the fit has.

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
    gives_way = float(slope @ solve_modes(twin.structure).out_of_band @ slope)
    own = min(max(twin.residual_compliance, 0.0), 1.0)
    left = 1 / stiffness + gives_way * (own - share)
    return 1 / left if left > 0 else None
