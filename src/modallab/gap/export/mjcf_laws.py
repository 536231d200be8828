"""Laws that depend on the size of the motion, as MuJoCo's own springs: one that stiffens, and one with free play.

A fixed tendon is a combination of joints that is as long as what the law feels: a deflection, or the slope at the root.
"""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.gap.export.chain import JointedChain, mass_orthonormal
from modallab.twin.bench import Twin
from modallab.twin.elements import slope_rows
from modallab.twin.modes import solve_modes
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw
from modallab.twin.structure import TwinStructure


def require_linear_twin(twin: Twin, form: str) -> None:
    """Reject a twin that does not answer in proportion to the force, for a form that is linear.

    Raises:
        DataError: it does not.
    """
    if twin.element is not None:
        raise DataError(
            f"the twin is not linear ({twin.element.law.name.lower()}), and {form} is linear",
            remedy="export a cubic spring or a play as mjcf; for another law use `modallab gap predict`",
        )


def tendon_of_law(
    element: NonlinearElement, structure: TwinStructure, found: JointedChain, mass: Real
) -> tuple[Real, dict[str, str]]:
    """What the law's tendon takes of each joint, (joints,), and its spring.

    Args:
        element: the law.
        structure: the beam that it acts on.
        found: its chain.
        mass: (joints, joints) of the chain.

    Raises:
        DataError: MuJoCo's springs do not have this law.
    """
    if element.law is NonlinearLaw.CUBIC:
        # It acts at a node.
        row = found.displacement[int(np.argmin(np.abs(found.nodes_m - element.x_m)))]
        # Of the length's first, second and third power.
        spring = {"stiffness": f"0 0 {element.numbers[0]!r}", "springlength": "0"}
    elif element.law is NonlinearLaw.PLAY:
        (slope,) = slope_rows(element.x_m, structure.length_m)
        row = mass @ mass_orthonormal(found.modes, mass) @ _row_in_modes(structure, slope)
        contact, gap = element.numbers
        spring = {"stiffness": repr(contact), "springlength": f"{-gap!r} {gap!r}"}
    else:
        raise DataError(
            f"MuJoCo has no spring with the law of this twin ({element.law.name.lower()})",
            remedy="predict records with `modallab gap predict`",
        )
    return row, spring


def _row_in_modes(structure: TwinStructure, row: Real) -> Real:
    """(m,) what a row over the elements' degrees of freedom is in each shape of unit modal mass."""
    modes = solve_modes(replace(structure, dampers=()))
    return np.asarray(np.real(row @ modes.columns * np.sqrt(2j * modes.poles.imag)), dtype=np.float64)
