"""The demo's rig with a second shaker near its tip, and force transducers that neither come first nor stand alike."""

from modallab.core.hardware import Shaker
from modallab.core.rig import Rig
from modallab.core.units import TO_SI

TIP = "force_tip"


def two_shakers(rig: Rig, point: int = 9, output: str = "") -> Rig:
    """The rig with its own force channel last, and in its midst one that reads lbf and stands against the drive."""
    per_lbf = TO_SI["force"]["lbf"]
    own = rig.force_channel
    volts = own.sensitivity_v_per_unit
    assert isinstance(volts, dict)
    tip = own.model_copy(
        update={
            "name": TIP,
            "direction": "-z",
            "unit": "lbf",
            "serial": "FT-0002",
            "sensitivity_v_per_unit": {test: value * per_lbf for test, value in volts.items()},
        }
    )
    channels = [*rig.responses[:3], tip, *rig.responses[3:], own]
    numbered = tuple(c.model_copy(update={"index": n}) for n, c in enumerate(channels))
    shakers = (Shaker(point=point, force=TIP, output=output),)
    return Rig.model_validate(rig.model_copy(update={"channels": numbered, "shakers": shakers}).model_dump())
