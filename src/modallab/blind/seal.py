"""The truth of trials, sealed: its hash is published before anybody answers, and checked when it is read.

A commitment by hash with a nonce (Naor, J. Cryptol. 4, 1991, 151): the truth can be neither guessed from the hash nor
changed after it. A seal keeps from accident, not from malice: who draws by a known seed can draw again.
"""

import hashlib
import json
import secrets
from pathlib import Path
from typing import Any

from modallab.core.errors import DataError, FormatError
from modallab.formats.atomic import write_text

HASHES = "hashes.json"
SEALED = "sealed"


def seal_truth(folder: Path, name: str, truth: dict[str, Any]) -> str:
    """Keep a truth, and give its hash."""
    place = folder / SEALED / f"{name}.json"
    place.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"nonce": secrets.token_hex(16), "truth": truth}, sort_keys=True)
    write_text(place, text)
    return hash_of(text)


def sealed_hash(folder: Path, name: str) -> str | None:
    """The hash of a truth that is kept; None if it is not there."""
    place = folder / SEALED / f"{name}.json"
    return hash_of(place.read_text(encoding="utf-8")) if place.exists() else None


def publish_hashes(folder: Path, plan: dict[str, Any], hashes: dict[str, str]) -> str:
    """Write down the hashes of all truths with the hash of them all, before anybody answers; gives the latter.

    Raises:
        DataError: other hashes were published here before.
    """
    whole = hash_of(json.dumps(hashes, sort_keys=True))
    known = published_hashes(folder)
    if known is not None and known["hash"] != whole:
        raise DataError(
            "other trials were sealed in this folder", where=str(folder / HASHES), remedy="name an empty folder"
        )
    if known is None:
        content = {"hash": whole, "plan": plan, "trials": hashes}
        write_text(folder / HASHES, json.dumps(content, indent=1) + "\n")
    return whole


def published_hashes(folder: Path) -> dict[str, Any] | None:
    """What was published in a folder; None if nothing was.

    Raises:
        FormatError: it cannot be read.
    """
    place = folder / HASHES
    if not place.exists():
        return None
    try:
        return json.loads(place.read_text(encoding="utf-8"))
    except ValueError as error:
        raise FormatError(f"is no JSON: {error}", where=str(place), remedy="name another folder") from error


def open_truth(folder: Path, name: str) -> dict[str, Any]:
    """A truth, once all is answered.

    Raises:
        DataError: it is not the one whose hash was published.
    """
    content = published_hashes(folder)
    text = (folder / SEALED / f"{name}.json").read_text(encoding="utf-8")
    if content is None or content["trials"].get(name) != hash_of(text):
        raise DataError(
            f"the truth of {name} is not the one that was sealed", where=str(folder / SEALED), remedy="draw new trials"
        )
    return json.loads(text)["truth"]


def hash_of(text: str) -> str:
    """SHA-256 of a text, as hexadecimal digits."""
    return hashlib.sha256(text.encode()).hexdigest()
