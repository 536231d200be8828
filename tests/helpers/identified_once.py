"""The same blocks with the same options are identified once, whichever command of a page asks for it."""

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256

import pytest

from modallab.core.block import Block, Campaign
from modallab.identification.options import Options
from modallab.pipelines import identify
from modallab.pipelines.identify import Identified

Identify = Callable[[Campaign, tuple[Block, ...], Options], Identified]


@contextmanager
def identified_once() -> Iterator[None]:
    """What was found is given again to who asks for it again."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_impact", "_sine"):
            patch.setattr(identify, name, _once(getattr(identify, name)))
        yield


def _once(find: Identify) -> Identify:
    found: dict[tuple[bytes, Options], Identified] = {}

    def find_once(campaign: Campaign, blocks: tuple[Block, ...], options: Options) -> Identified:
        key = sha256(pickle.dumps((campaign.rig, blocks))).digest(), options
        if key not in found:
            found[key] = find(campaign, blocks, options)
        return found[key]

    return find_once
