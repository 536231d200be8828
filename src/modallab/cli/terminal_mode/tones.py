"""Tones, so that the operator need not look: made here, played by the system's player, else by the terminal's bell."""

import shutil
import subprocess
import sys
import tempfile
import time
import wave
from pathlib import Path
from queue import SimpleQueue
from threading import Thread

import numpy as np

from modallab.cli.terminal_mode.session_state import Phase

RATE_HZ = 22050
PLAYERS = (("paplay",), ("aplay", "-q"), ("afplay",))

TONES: dict[Phase, tuple[tuple[float, float], ...]] = {
    "strike": ((880.0, 0.35),),
    "good": ((660.0, 0.1), (990.0, 0.15)),
    "rejected": ((330.0, 0.25), (220.0, 0.35)),
    "early": ((440.0, 0.08), (0.0, 0.05), (440.0, 0.08), (0.0, 0.05), (440.0, 0.08)),
}
"""Hz and s of each part; 0 Hz is a gap. High: strike; rising: good; falling: rejected; three short: too early."""

BELLS: dict[Phase, int] = {"strike": 1, "good": 0, "rejected": 2, "early": 3}
"""How often the bell rings where nothing can be played; it has one tone only."""
BELL_S = 0.15


class Tones:
    """Plays one tone after another, in a thread of its own."""

    def __init__(self, *, mute: bool) -> None:
        self._mute = mute
        self._wanted: SimpleQueue[Phase | None] = SimpleQueue()
        self._folder = tempfile.TemporaryDirectory(prefix="modallab-tones-", ignore_cleanup_errors=True)
        self._player = _sound_player()
        self._thread = Thread(target=self._work, name="tones", daemon=True)
        self._thread.start()

    def play(self, phase: Phase) -> None:
        """Play the tone of a phase, if it has one."""
        if not self._mute and phase in TONES:
            self._wanted.put(phase)

    def close(self) -> None:
        """Play what is still wanted, then end."""
        self._wanted.put(None)
        self._thread.join(2.0)
        self._folder.cleanup()

    def _work(self) -> None:
        while (phase := self._wanted.get()) is not None:
            if not self._played(phase):
                _ringing_tone(BELLS[phase])

    def _played(self, phase: Phase) -> bool:
        file = Path(self._folder.name) / f"{phase}.wav"
        if not file.exists():
            write_tone(file, TONES[phase])
        if sys.platform == "win32":
            import winsound

            winsound.PlaySound(str(file), winsound.SND_FILENAME)
            return True
        if self._player is None:
            return False
        done = subprocess.run([*self._player, str(file)], check=False, capture_output=True, timeout=5)
        if done.returncode:
            # A machine without a sound card has the player all the same.
            self._player = None
        return done.returncode == 0


def write_tone(file: Path, parts: tuple[tuple[float, float], ...]) -> None:
    """Write a tone as 16-bit WAV, each part with soft ends."""
    pieces: list[np.ndarray] = []
    for hz, seconds in parts:
        t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
        ends = np.clip(np.minimum(t, seconds - t) / 0.01, 0, 1)
        pieces.append(0.6 * ends * np.sin(2 * np.pi * hz * t))
    with wave.open(str(file), "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE_HZ)
        out.writeframes((32767 * np.concatenate(pieces)).astype("<i2").tobytes())


def _sound_player() -> tuple[str, ...] | None:
    return next((player for player in PLAYERS if shutil.which(player[0])), None)


def _ringing_tone(times: int) -> None:
    for _ in range(times):
        sys.stdout.write("\a")
        sys.stdout.flush()
        time.sleep(BELL_S)
