"""Before a first test: the check of a rig, and calibration."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.commissioning.calibrate import by_reference, by_rigid_mass, by_step, by_turnover, entered
    from modallab.commissioning.rig_check import Finding, check_clock, check_idle, check_polarity

__all__ = [
    "Finding",
    "by_reference",
    "by_rigid_mass",
    "by_step",
    "by_turnover",
    "check_clock",
    "check_idle",
    "check_polarity",
    "entered",
]

__getattr__ = lazily(
    __name__,
    {
        "calibrate": ("by_reference", "by_rigid_mass", "by_step", "by_turnover", "entered"),
        "rig_check": ("Finding", "check_clock", "check_idle", "check_polarity"),
    },
)
