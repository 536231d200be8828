"""Drawings that a script moves, with a button to stop them."""

from importlib.resources import files

from modallab.reporting.markup import Markup, html_element, trusted_markup


def moving_pictures(pictures: list[Markup], class_: str, script: str) -> Markup:
    """Pictures in a box of a class, which a script of this package moves by `swing.js`."""
    folder = files("modallab.reporting")
    code = "".join(folder.joinpath(name).read_text(encoding="utf-8") for name in ("swing.js", script))
    button = html_element("button", "Hold still", type="button", hidden=True)
    box = html_element("div", button, html_element("div", *pictures, class_="beams"), class_=class_)
    return trusted_markup(box + html_element("script", trusted_markup(code)))
