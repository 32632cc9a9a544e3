"""The report is one file that needs no other, says pass and fail, and escapes what it is given."""

from __future__ import annotations

from html.parser import HTMLParser

from matplotlib.figure import Figure

from rollerrig.study.report import (
    Mark,
    Page,
    Picture,
    Preformatted,
    Section,
    Table,
    Text,
    render,
)

PNG = b"\x89PNG\r\n\x1a\n"


class Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("img", "meta", "link", "br"):
            self.open.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def page() -> Page:
    table = Table(("a", "b"), [("text <b>", 1.5), (2, "✔ pass")], "caption")
    blocks = [Text("1 < 2 & 3"), Picture("a", Figure(), "a picture", PNG), table, Preformatted("config", "x = '<y>'")]
    return Page("A title", "summary", [Section("One thing", blocks)], "footer")


def test_the_page_is_well_formed_and_needs_nothing_else() -> None:
    reader = Reader()
    reader.feed(render(page()))
    assert reader.open == []
    assert all(link.startswith(("#", "data:")) for link in reader.links)


def test_what_is_given_is_escaped() -> None:
    text = render(page())
    assert "text &lt;b&gt;" in text
    assert "1 &lt; 2 &amp; 3" in text


def test_the_kind_of_a_picture_is_known() -> None:
    assert Picture("a", Figure(), "", PNG).source.startswith("data:image/png;base64,")
    assert Picture("a", Figure(), "", b"<svg/>").source.startswith("data:image/svg+xml;base64,")


def test_printed_pages_are_numbered_and_marked() -> None:
    """A browser prints the page number in the margin; what must not be quoted says so on every printed page."""
    marked = render(Page("A title", "summary", [], mark=Mark("quick", "few runs")))
    assert 'content: counter(page) " / " counter(pages)' in marked
    assert ".mark { position: fixed;" in marked.partition("@media print")[2]
    assert '<p class="mark"><strong>QUICK</strong>: few runs.</p>' in marked
    assert '<p class="mark">' not in render(page())


def test_the_answer_stands_in_the_first_five_lines_and_details_are_folded() -> None:
    lines = [f"finding {k}" for k in range(7)]
    sections = [Section("First", [Text("seen")]), Section("Solver", [Text("a detail")], folded=True)]
    text = render(Page("A title", "\n".join(lines), sections))
    top, _, rest = text.partition("<details>")
    assert [line in top for line in lines] == [True] * 5 + [False] * 2
    assert "2 further findings" in rest.partition("</details>")[0]
    assert text.index("seen") < text.index("<details><summary><h2>Solver</h2></summary>") < text.index("a detail")
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert "further finding" not in render(Page("A title", "one\ntwo", sections))


def test_columns_of_numbers_are_set_to_the_right_with_their_dashes() -> None:
    table = Table(
        ("name", "force [kN]", "limit"), [("a", "1\u202f234.5", "at most 2"), ("b", "–", "–"), ("c", "-3·10⁻⁴", 5.0)]
    )
    assert table.of_numbers == [False, True, False]
    text = render(Page("A title", "summary", [Section("One", [table])]))
    assert '<th class="n">force [kN]</th>' in text
    assert text.count('<td class="n">') == 3
    assert Table(("a",), []).of_numbers == [False]


def test_a_row_of_sentences_names_its_columns_for_a_narrow_screen() -> None:
    long = Table(("of", "why"), [("one", "a sentence that is too long for one narrow column of a table")])
    short = Table(("of", "why"), [("one", "a word")])
    assert (long.of_sentences, short.of_sentences) == (True, False)
    text = render(Page("A title", "summary", [Section("One", [long, short])]))
    assert text.count('<table class="sentences">') == 1
    assert text.count('<td data-head="why">') == 1


def test_a_marked_page_says_so_once_above_its_answer() -> None:
    text = render(Page("A title", "finding", [], mark=Mark("quick", "few runs")))
    assert text.count("few runs") == 1
