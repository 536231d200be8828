"""The commands an operator may send to a run that is going on."""

from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.documents.runs import Abort, Command, Drop, Pause, Repeat, Resume
from modallab.service.errors import NotFoundError
from modallab.service.records import audit
from modallab.service.rigs.active_run import ActiveRun
from modallab.service.rigs.transitions import require_action


def notify(process: RigProcess, active: ActiveRun, command: Command, operator: str) -> None:
    """Pass a command on, and keep who gave it.

    Raises:
        IllegalTransitionError: the run's state has no step for it.
        PlanError: a frequency or level the plan does not have.
        NotFoundError: a block the run does not have.
    """
    require_action(active.state, command.kind)
    detail = command.model_dump(mode="json")
    if isinstance(command, Repeat):
        process.repeat(command.frequency_hz, command.level or "")
    elif isinstance(command, Drop):
        process.drop(_block_name(active, command.n), command.reason)
    else:
        _simple(process, command)
    audit.enter(active.diary.engine, operator, command.kind, active.run, detail)


def _simple(process: RigProcess, command: Command) -> None:
    if isinstance(command, Pause):
        process.pause()
    elif isinstance(command, Resume):
        process.resume()
    elif isinstance(command, Abort):
        process.abort()
    else:
        process.stop()


def _block_name(active: ActiveRun, n: int) -> str:
    for block in active.diary.store.catalogue.blocks(active.run):
        if block.n == n:
            return block.note.name
    raise NotFoundError(f"run {active.run} has no block {n}", where="n", remedy="look at the list of its blocks")
