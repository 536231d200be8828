"""Who swings the hammer when the bench does not decide it: a script, over a datagram socket on this machine.

Each datagram is one act as JSON: `{"act": "strike", "point": 3}`, with `peak_n`, `width_s`, `after_s`, `rebound_s` and
`rebound_share` for a double hit, `oblique_deg`, `beside_m`; or `{"act": "hold", "seconds": 2}`, a hand on the beam.
"""

import json
import socket
from dataclasses import dataclass
from math import cos, radians
from typing import Any

from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever.hammer import ContactPulse, Hit

LARGEST = 4096


@dataclass(frozen=True, slots=True)
class ScriptedHit:
    """A hit as the script means it.

    Attributes:
        point: of the rig, whatever point was asked for.
        peak_n: of the force along the hammer.
        width_s: of the contact.
        after_s: from now to the contact.
        rebound_s: to a second contact; 0 for none.
        rebound_share: its peak over the first's.
        oblique_deg: between the hammer and the normal of the beam, which gets the cosine of the force.
        beside_m: from the point, away from the clamp.
    """

    point: int
    peak_n: float = 80.0
    width_s: float = 0.003
    after_s: float = 0.0
    rebound_s: float = 0.0
    rebound_share: float = 0.4
    oblique_deg: float = 0.0
    beside_m: float = 0.0

    def hits(self, now_s: float, x_m: float) -> list[Hit]:
        """What acts: on the beam, and on the hammer's transducer alone, which stands on the clamp for that."""
        start, share = now_s + self.after_s, cos(radians(self.oblique_deg))
        contacts = [ContactPulse(start, self.width_s, self.peak_n)]
        if self.rebound_s:
            contacts.append(ContactPulse(start + self.rebound_s, self.width_s, self.peak_n * self.rebound_share))
        on_beam = Hit(x_m, _scaled(contacts, share))
        return [on_beam] if share == 1 else [on_beam, Hit(0.0, _scaled(contacts, 1 - share))]


@dataclass(frozen=True, slots=True)
class HandHold:
    """A hand that is laid on the beam and damps all its modes."""

    seconds: float


Act = ScriptedHit | HandHold


class OperatorLine:
    """The bench's end."""

    def __init__(self, port: int) -> None:
        """Listen on a port of this machine.

        Raises:
            ConfigurationError: somebody else does.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind(("127.0.0.1", port))
        except OSError as error:
            self._socket.close()
            raise ConfigurationError(f"operator is {port}: {error}", remedy="name a free port") from error

    def acts(self) -> list[Act]:
        """What was asked for since the last look.

        Raises:
            ConfigurationError: something that is no act.
        """
        found: list[Act] = []
        while True:
            try:
                text = self._socket.recv(LARGEST)
            except BlockingIOError:
                return found
            found.append(_read(text))

    def close(self) -> None:
        """Stop listening."""
        self._socket.close()


def _read(text: bytes) -> Act:
    try:
        fields: dict[str, Any] = json.loads(text)
        kinds: dict[str, type[Act]] = {"strike": ScriptedHit, "hold": HandHold}
        return kinds[fields.pop("act")](**fields)
    except (ValueError, KeyError, TypeError) as error:
        raise ConfigurationError(f"{text!r} is no act of an operator", remedy="send strike or hold as JSON") from error


def _scaled(contacts: list[ContactPulse], share: float) -> tuple[ContactPulse, ...]:
    return tuple(ContactPulse(c.start_s, c.width_s, c.peak_n * share) for c in contacts)
