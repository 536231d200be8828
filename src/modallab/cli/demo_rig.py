"""The demo's rig and tests, without what the demo needs to record, to identify and to draw."""

from importlib.resources import files

from modallab.core.plan import BLOCK_S, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig

DEMO_POINTS = (10, 6, 3)
"""The free end, where every mode moves, and two points where the second and third move against it."""
BESIDE = (5, 6, 28, 33, 35, 84, 92, 96)
"""Lines beside the first three resonances, driven at a second level: whether the bench answers in proportion."""
HIGH_V = 0.8
"""That level: higher by more than half, and within the limits of the rig at every seed."""


def demo_rig() -> Rig:
    """The paper's link as a rig."""
    resource = files("modallab.cli").joinpath("link_rig.yaml")
    return parse_rig(resource.read_text(encoding="utf-8"), "the demo's rig")


def demo_plans() -> tuple[Plan, ...]:
    """The impact test, five hits at each of three points, and the sine test, 24 frequencies and some again, higher."""
    again = tuple(n / BLOCK_S for n in BESIDE)
    return (
        ImpactPlan(points=DEMO_POINTS, hits=5),
        SinePlan(),
        SinePlan(frequencies_hz=again, levels_v={"high": HIGH_V}),
    )
