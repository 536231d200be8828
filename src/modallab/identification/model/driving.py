"""Which sensors tell a driving point: those at the point that is struck and along the way it is struck."""

from modallab.core.rig import Rig


def driving_points(rig: Rig) -> tuple[int | None, ...]:
    """(responses,) the point of each response that moves along the drive's axis, None for every other."""
    axis = rig.drive_direction[1]
    return tuple(c.point if c.direction[1] == axis else None for c in rig.responses)
