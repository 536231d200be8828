"""The demo's rig: for `modallab serve` too, which starts without what the demo needs to identify and to draw."""

from importlib.resources import files

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig


def demo_rig() -> Rig:
    """The paper's link as a rig."""
    resource = files("modallab.cli").joinpath("link_rig.yaml")
    return parse_rig(resource.read_text(encoding="utf-8"), "the demo's rig")
