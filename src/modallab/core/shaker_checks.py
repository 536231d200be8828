"""What must hold between the shakers of a rig, its force channels and its points."""

from collections.abc import Mapping, Sequence
from typing import cast

from modallab.core.rig_problem import INVALID, Problem, number, shown


def shaker_problems(
    content: Mapping[str, object], channels: Sequence[Mapping[str, object]], shakers: Sequence[Mapping[str, object]]
) -> list[Problem]:
    """What is wrong between the shakers beside the first one and the rest of the rig."""
    if not shakers:
        return []
    problems: list[Problem] = []
    first = content.get("shaker_point")
    if first is None:
        problems.append(Problem("shaker_point", "missing", "the point of the first shaker, where others are listed"))
    points = [number(first), *(number(shaker.get("point")) for shaker in shakers)]
    excitation = content.get("excitation")
    wired = cast("Mapping[str, object]", excitation).get("output") if isinstance(excitation, Mapping) else ""
    problems += _repeated_of_shakers("point", points)
    problems += _repeated_of_shakers("output", [_text(wired), *(_text(shaker.get("output")) for shaker in shakers)])
    problems += _repeated_of_shakers("force", [None, *(_text(shaker.get("force")) for shaker in shakers)])
    return problems + _force_channel_problems(channels, shakers)


def _force_channel_problems(
    channels: Sequence[Mapping[str, object]], shakers: Sequence[Mapping[str, object]]
) -> list[Problem]:
    if any(channel.get("quantity", INVALID) is INVALID or channel.get("name") is INVALID for channel in channels):
        return []
    forces = [channel.get("name") for channel in channels if channel.get("quantity") == "force"]
    named = [shaker.get("force") for shaker in shakers]
    problems = [
        Problem(f"shakers[{place}].force", f"found {name!r}", f"the name of a channel of quantity force: {forces}")
        for place, name in enumerate(named)
        if isinstance(name, str) and name not in forces
    ]
    if not problems and forces and all(name in named for name in forces):
        problems.append(
            Problem(
                "shakers", f"all force channels, {forces}", "one channel of quantity force left for the first shaker"
            )
        )
    return problems


def _repeated_of_shakers(field: str, values: Sequence[str | float | None]) -> list[Problem]:
    """Values of the first shaker and of those listed that occur twice; None: not known."""
    return [
        Problem(f"shakers[{place - 1}].{field}", f"found {shown(value)}, as of another shaker", "each once")
        for place, value in enumerate(values)
        if value is not None and values.index(value) < place
    ]


def _text(value: object) -> str | None:
    return value if isinstance(value, str) and value else None
