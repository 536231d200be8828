"""Before a first test: the check of a rig, and calibration."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.commissioning.calibrate import by_reference, by_rigid_mass, by_step, by_turnover, with_calibration
    from modallab.commissioning.findings import Finding
    from modallab.commissioning.rig_check import check_clock, check_idle, check_polarity
    from modallab.commissioning.synchronisation_check import check_common_signal, check_synchronisation

__all__ = [
    "Finding",
    "by_reference",
    "by_rigid_mass",
    "by_step",
    "by_turnover",
    "check_clock",
    "check_common_signal",
    "check_idle",
    "check_polarity",
    "check_synchronisation",
    "with_calibration",
]

__getattr__ = lazily(
    __name__,
    {
        "calibrate": ("by_reference", "by_rigid_mass", "by_step", "by_turnover", "with_calibration"),
        "findings": ("Finding",),
        "rig_check": ("check_clock", "check_idle", "check_polarity"),
        "synchronisation_check": ("check_common_signal", "check_synchronisation"),
    },
)
