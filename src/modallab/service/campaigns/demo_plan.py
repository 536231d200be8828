"""What the demo does on the bench: the paper's two tests."""

from modallab.core.plan import ImpactPlan, Plan, SinePlan

DEMO_POINTS = (10, 6, 3)
"""The free end, where every mode moves, and two points where the second and third move against it."""


def demo_plans() -> tuple[Plan, ...]:
    """The impact test, five hits at each of three points, and the sine test, 24 frequencies at one level."""
    return (ImpactPlan(points=DEMO_POINTS, hits=5), SinePlan())
