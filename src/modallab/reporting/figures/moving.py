"""Drawings that a script moves, with a button to stop them."""

from importlib.resources import files

from modallab.reporting.markup import Markup, tag, trusted


def moving(pictures: list[Markup], class_: str, script: str) -> Markup:
    """Pictures in a box of a class, which a script of this package moves by `swing.js`."""
    folder = files("modallab.reporting")
    code = "".join(folder.joinpath(name).read_text(encoding="utf-8") for name in ("swing.js", script))
    button = tag("button", "Hold still", type="button", hidden=True)
    box = tag("div", button, tag("div", *pictures, class_="beams"), class_=class_)
    return trusted(box + tag("script", trusted(code)))
