"""What any report page must be: whole, linked, offline, small; read with the standard library's HTML parser."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from html.parser import HTMLParser

LARGEST = 5_000_000
"""Largest size of a page [bytes]."""
VOID = {"meta", "link", "img", "input", "br", "wbr", "hr", "source", "line", "circle", "rect"}
ATTRIBUTES = ("src", "href", "srcset", "action", "data", "poster")


@dataclass
class Page(HTMLParser):
    """Parser that collects the parts of an HTML page that are checked.

    Args:
        ids: as often as they occur.
        links: targets within the page.
        outside: whatever a browser would fetch from elsewhere.
        unclosed: elements that were closed in a wrong order.
    """

    text: str
    ids: Counter[str] = field(default_factory=Counter)
    links: list[str] = field(default_factory=list)
    outside: list[str] = field(default_factory=list)
    unclosed: list[str] = field(default_factory=list)
    images: int = 0
    tags: Counter[str] = field(default_factory=Counter)
    _open: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.text)
        self.unclosed += self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        values = {k: v or "" for k, v in attrs}
        if "id" in values:
            self.ids[values["id"]] += 1
        for name in ATTRIBUTES:
            target = values.get(name, "")
            if target.startswith("#"):
                self.links.append(target[1:])
            elif name in values and tag != "object" and re.match(r"(?:[a-z]+:)?//", target):
                self.outside.append(target)
        self.images += values.get("src", "").startswith("data:image/")
        if tag == "link" or tag == "iframe" or (tag == "script" and "src" in values):
            self.outside.append(self.get_starttag_text() or tag)
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag: str) -> None:
        if self._open and self._open[-1] == tag:
            self._open.pop()
        else:
            self.unclosed.append(f"</{tag}>")


def faults(text: str) -> list[str]:
    """Describe every fault of an HTML page, such as a broken link or a request to another site."""
    page = Page(text)
    found = [f"id '{i}' occurs {n} times" for i, n in page.ids.items() if n > 1]
    found += [
        f"a link leads to '#{link}', which is not there" for link in dict.fromkeys(page.links) if link not in page.ids
    ]
    found += [f"not within the page: {url}" for url in page.outside]
    found += [f"not closed in order: {tag}" for tag in page.unclosed[:3]]
    code = re.sub(r"base64,[^\"]*", "", text)
    found += [f"an address: {url}" for url in re.findall(r"(?:https?:)?//[a-z0-9.-]+\.[a-z]{2,}", code)]
    found += [f"a style fetches {url}" for url in re.findall(r"(?:@import|url\()[^;]*", code)]
    return found + ([f"{len(text.encode())} bytes"] if len(text.encode()) > LARGEST else [])
