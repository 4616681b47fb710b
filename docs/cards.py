"""Cards of the site: a picture, a title, a line in plain words, and links."""

import html
from collections.abc import Sequence
from typing import NamedTuple


class Link(NamedTuple):
    """The words of a link and its address, relative to the page that holds it."""

    words: str
    address: str


def card(title: str, line: str, picture: str, page: str, links: Sequence[Link] = ()) -> str:
    """A card whose picture and title lead to `page`, with more links below its line."""
    words, text, address = html.escape(title), html.escape(line), html.escape(page)
    shown = (
        f'<a class="picture" href="{address}" tabindex="-1" aria-hidden="true">'
        f'<img src="{html.escape(picture)}" alt="" loading="lazy"></a>'
        if picture
        else ""
    )
    more = " · ".join(f'<a href="{html.escape(link.address)}">{html.escape(link.words)}</a>' for link in links)
    below = f'<p class="links">{more}</p>' if more else ""
    title_link = f'<a class="title" href="{address}">{words}</a>'
    return f'<div class="card">{shown}{title_link}<p>{text}</p>{below}</div>'


def grid(cards: Sequence[str]) -> str:
    """Cards side by side, as many as the page is wide."""
    return f'<div class="cards">{"".join(cards)}</div>\n'
