"""`modallab gap effects`: what may be wrong with a bench, and what the diagnosis knows of it."""

import argparse

from rich.console import Console

from modallab.core.effects import Parameter, catalogue
from modallab.twin.effect_model import EffectModel, NoChange
from modallab.twin.effects import model_of


def run(arguments: argparse.Namespace) -> int:
    """List the catalogue, or describe some effects of it."""
    console = Console(soft_wrap=True)
    for name in arguments.names or catalogue():
        model = model_of(name)
        lines = _describe_effect(model) if arguments.names else [f"{name:<18} {model.kind.says}"]
        for line in lines:
            console.print(line, markup=False, highlight=False)
    return 0


def _describe_effect(model: EffectModel) -> list[str]:
    kind = model.kind
    why = model.change.value if isinstance(model.change, NoChange) else ""
    known = f"No fit can find this effect: {why}." if why else "A fit can find this effect."
    return [
        f"{kind.name}: {kind.says}",
        f"  stage {kind.stage}, place {kind.place}, shows in {' and '.join(kind.tests)}",
        *(f"  {_range_in_words(parameter)}" for parameter in kind.parameters),
        f"  {known}",
        f"  {model.experiment}",
    ]


def _range_in_words(parameter: Parameter) -> str:
    scale = "" if parameter.scale == "one" else f" times {parameter.scale}"
    sign = ", either sign" if parameter.signed else ""
    return (
        f"{parameter.name}, {parameter.unit or 'a pure number'}: {parameter.low:g} to {parameter.high:g}{scale}{sign}"
    )
