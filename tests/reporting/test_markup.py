import pytest
from page_reader import Page

from modallab.reporting.markup import html_element, html_table, join_markup, trusted_markup

EVIL = "<script>alert('x')</script>\"&"


def test_text_is_escaped_everywhere_but_markup_is_kept():
    made = html_element("p", EVIL, html_element("b", "bold"), title=EVIL)
    assert "<script>" not in made
    assert "<b>bold</b>" in made
    page = Page(made)
    assert page.text == EVIL + "bold"
    assert page.all("p") == [{"title": EVIL}]


def test_attributes_lose_their_underscores_and_flags_stand_alone():
    assert html_element("i", class_="a b", aria_label="x", hidden=True, open=False, id="") == (
        '<i class="a b" aria-label="x" hidden></i>'
    )
    assert html_element("br") == "<br>"
    assert html_element("meta", name="viewport") == '<meta name="viewport">'


def test_join_leaves_none_out():
    assert join_markup(["<", None, trusted_markup("<br>")]) == "&lt;<br>"


@pytest.mark.parametrize("rows", [[("1", EVIL)], []])
def test_a_table_has_headers_for_columns_and_rows(rows):
    made = Page(html_table("What " + EVIL, ("a", "b"), rows, (1,)))
    assert made.tables[0].caption == "What " + EVIL
    assert made.tables[0].rows == [["a", "b"], *[list(r) for r in rows]]
    assert made.tables[0].scopes == ["col", "col"] + ["row"] * len(rows)
