"""What the operator should see now, folded from the events of a session."""

from dataclasses import dataclass, replace
from typing import Any, Literal, Self

from modallab.core.documents.pages import EventView

Phase = Literal["begin", "wait", "strike", "record", "good", "rejected", "early", "paused", "move", "drive", "ended"]


@dataclass(frozen=True, slots=True)
class SessionState:
    """One moment of a session.

    Attributes:
        phase: what happens now.
        run: the active run.
        point: to strike.
        hit: its number there.
        of: how many there.
        done: hits or bursts that count.
        total: how many the plan wants.
        text: one line besides: how long to wait, which frequency.
        news: what became of the hit before, until the next one.
        compared: whether the simulation agrees with what was recorded last.
        last_good: number of the block that was kept last, which an undo takes back; None if there is none.
        last_rejected: number of the block that was rejected last, which may be accepted; None if there is none.
    """

    phase: Phase = "begin"
    run: str = ""
    point: int = 0
    hit: int = 0
    of: int = 0
    done: int = 0
    total: int = 0
    text: str = ""
    news: str = ""
    compared: str = ""
    last_good: int | None = None
    last_rejected: int | None = None

    def after_event(self, event: EventView) -> Self:
        """The state once this event has happened; the same object if the operator need not know."""
        said, run = event.content, event.run or ""
        if run != self.run:
            fresh = type(self)(run=run)
            return fresh.after_event(event) if fresh.run == run and run else fresh
        handler = _HANDLERS.get(event.kind)
        return self if handler is None else replace(self, **handler(self, said))


Said = dict[str, Any]


def _requested(_: SessionState, said: Said) -> Said:
    return {"phase": "strike", "text": "", "point": said["point"], "hit": said["hit"], "of": said["of"]}


def _waiting(_: SessionState, said: Said) -> Said:
    still = f"{said['residual_hz']:.3g} Hz rings"
    if said["residual_ratio"] is not None:
        still += f" with {100 * said['residual_ratio']:.2g} % of a hit, {100 * said['allowed']:g} % is allowed"
    still += "; stop the structure by hand"
    if said["remaining_s"] is not None:
        still += f", or wait {said['remaining_s']:.0f} s"
    return {"phase": "wait", "text": still, "point": said["point"], "hit": said["hit"], "of": said["of"]}


def _early(_: SessionState, said: Said) -> Said:
    return {"phase": "early", "text": "", "news": f"too early ({said['peak_n']:.3g} N): wait for the tone"}


def _rejected(_: SessionState, said: Said) -> Said:
    return {"phase": "rejected", "text": "", "news": f"rejected: {said['reason']}", "point": said["point"]}


def _block(_: SessionState, said: Said) -> Said:
    if said["accepted"]:
        return {"phase": "good", "text": "", "news": "", "last_good": said["n"], "last_rejected": None}
    return {"last_rejected": said["n"]}


def _dropped(_: SessionState, said: Said) -> Said:
    return {"phase": "wait", "news": f"{said['name']}: {said['reason']}", "last_good": None}


def _accepted(_: SessionState, said: Said) -> Said:
    return {"phase": "good", "news": f"{said['name']}: {said['reason']}", "last_rejected": None}


def _progress(_: SessionState, said: Said) -> Said:
    return {"done": said["done"], "total": said["total"]} | (
        {"phase": "drive", "text": said["what"]} if said["what"].startswith("level ") else {}
    )


def _run_state(state: SessionState, said: Said) -> Said:
    if said["state"] == "paused":
        return {"phase": "paused", "text": ""}
    if said["state"] in ("done", "failed", "aborted"):
        return {"phase": "ended", "text": said["reason"]}
    if said["state"] == "acquiring":
        return {"phase": "wait" if state.phase == "paused" else "record", "text": ""}
    return {}


def _text(_: SessionState, said: Said) -> Said:
    return {"text": said["what"]}


_HANDLERS = {
    "hit_requested": _requested,
    "waiting_for_rest": _waiting,
    "hit_too_early": _early,
    "hit_rejected": _rejected,
    "block": _block,
    "dropped": _dropped,
    "accepted": _accepted,
    "progress": _progress,
    "state": _run_state,
    "notice": _text,
    "failed": _text,
}
