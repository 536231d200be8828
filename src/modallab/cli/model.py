"""`modallab model`: a modal model put to use."""

import argparse

from modallab.cli.model_behaviour import (
    frf,
    prepare_model,
    response,
    show_nodes,
    show_participation,
    show_reduction,
    show_shape,
    state_space,
)
from modallab.cli.model_change import absorber, compare, couple, free_band, modify, tune, update
from modallab.formats.rig.rig_file import read_rig


def run(arguments: argparse.Namespace) -> int:
    """Make the model ready, and do what was asked for."""
    rig = None if arguments.rig is None else read_rig(arguments.rig)
    known, compared = prepare_model(arguments.model, rig, arguments.test, progress=not arguments.hush)
    if arguments.action in WITH_FRFS:
        WITH_FRFS[arguments.action](known, compared, arguments)
    else:
        ACTIONS[arguments.action](known, arguments)
    return 0


WITH_FRFS = {"shape": show_shape, "reduction": show_reduction}
ACTIONS = {
    "modify": modify,
    "couple": couple,
    "tune": tune,
    "free": free_band,
    "absorber": absorber,
    "frf": frf,
    "response": response,
    "state-space": state_space,
    "participation": show_participation,
    "nodes": show_nodes,
    "compare": compare,
    "update": update,
}
