"""The hammer: its hit of one smooth contact or two, and the virtual operator who swings it."""

import json
import socket
from dataclasses import dataclass, replace
from math import cos, radians
from typing import Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class ContactPulse:
    """A contact pulse peak_n sin^2(pi t / width_s) from `start_s`."""

    start_s: float
    width_s: float
    peak_n: float

    def force(self, times_s: Real) -> Real:
        """Force in N at the given times."""
        share = (times_s - self.start_s) / self.width_s
        return np.where((share > 0) & (share < 1), self.peak_n * np.sin(np.pi * share) ** 2, 0.0)


@dataclass(frozen=True, slots=True)
class HammerHit:
    """What the hammer does at one place; or, where its transducer does not feel it, something else that knocks."""

    x_m: float
    contacts: tuple[ContactPulse, ...]
    seen: bool = True

    @property
    def start_s(self) -> float:
        """When the hammer first touches."""
        return self.contacts[0].start_s

    @property
    def end_s(self) -> float:
        """When it last lets go."""
        return self.contacts[-1].start_s + self.contacts[-1].width_s

    def delayed(self, wait_s: float) -> "HammerHit":
        """The same, later."""
        return replace(self, contacts=tuple(replace(c, start_s=c.start_s + wait_s) for c in self.contacts))

    def knock_before(self, share: float) -> "HammerHit":
        """A share of the first contact, which the transducer does not feel."""
        first = self.contacts[0]
        return HammerHit(self.x_m, (replace(first, peak_n=first.peak_n * share),), seen=False)

    def force(self, times_s: Real) -> Real:
        """Force in N at the given times."""
        return np.sum([contact.force(times_s) for contact in self.contacts], axis=0)


REACTION_S = (0.5, 1.5)
WIDTH_S = (0.0015, 0.005)
PEAK_N = (50.0, 150.0)
WEAK_N = (4.0, 8.0)
REBOUND_S = (0.015, 0.060)
REBOUND_SHARE = (0.15, 0.6)


@dataclass(frozen=True, slots=True)
class PlannedHit:
    """One hit as intended: times count from the prompt, the place from the point.

    Attributes:
        reaction_s: from the prompt to the contact.
        width_s: of the contact.
        peak_n: of the contact, before what the sensors bear is known.
        place_m: where it lands, from the point.
        weak_n: peak of a hit that is too weak; 0 for another.
        rebound_s: from the first contact's start to the second's; 0 for a clean hit.
        rebound_share: peak of the second contact over that of the first.
    """

    reaction_s: float
    width_s: float
    peak_n: float
    place_m: float
    weak_n: float = 0.0
    rebound_s: float = 0.0
    rebound_share: float = 0.0

    def slowed(self, waiting: float, contact: float) -> "PlannedHit":
        """The same with the time to the hit, and with those of the contact, longer by these factors."""
        return replace(
            self,
            reaction_s=self.reaction_s * waiting,
            width_s=self.width_s * contact,
            rebound_s=self.rebound_s * contact,
        )

    def hit(self, prompted_s: float, x_m: float, overload_force_n: float) -> HammerHit:
        """The hit at `x_m`, no harder than `overload_force_n`."""
        start = prompted_s + self.reaction_s
        peak = self.weak_n if self.weak_n else min(self.peak_n, overload_force_n)
        contacts = [ContactPulse(start, self.width_s, peak)]
        if self.rebound_s:
            contacts.append(ContactPulse(start + self.rebound_s, self.width_s, peak * self.rebound_share))
        return HammerHit(x_m, tuple(contacts))


def draw_hit(
    rng: np.random.Generator,
    bad_hits: float,
    place_m: float,
    peaks_n: tuple[float, float] = PEAK_N,
    reactions_s: tuple[float, float] = REACTION_S,
) -> PlannedHit:
    """Draw a hit; with probability `bad_hits` a bad one, as often a double hit as too weak."""
    reaction, width = rng.uniform(*reactions_s), rng.uniform(*WIDTH_S)
    peak, place = rng.uniform(*peaks_n), rng.standard_normal() * place_m
    bad, double = rng.uniform() < bad_hits, rng.uniform() < 0.5
    weak, gap, share = rng.uniform(*WEAK_N), rng.uniform(*REBOUND_S), rng.uniform(*REBOUND_SHARE)
    if not bad:
        return PlannedHit(reaction, width, peak, place)
    if double:
        return PlannedHit(reaction, width, peak, place, rebound_s=gap, rebound_share=share)
    return PlannedHit(reaction, width, peak, place, weak_n=weak)


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

    def hits(self, now_s: float, x_m: float) -> list[HammerHit]:
        """What acts: on the beam, and on the hammer's transducer alone, which stands on the clamp for that."""
        start, share = now_s + self.after_s, cos(radians(self.oblique_deg))
        contacts = [ContactPulse(start, self.width_s, self.peak_n)]
        if self.rebound_s:
            contacts.append(ContactPulse(start + self.rebound_s, self.width_s, self.peak_n * self.rebound_share))
        on_beam = HammerHit(x_m, _scaled(contacts, share))
        return [on_beam] if share == 1 else [on_beam, HammerHit(0.0, _scaled(contacts, 1 - share))]


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

    def next_actions(self) -> list[Act]:
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
