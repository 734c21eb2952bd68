"""Read parts of a report's page, for tests."""

from __future__ import annotations

from html.parser import HTMLParser

from ghostball.reports import write_report

VOID = {"meta", "link", "br", "wbr", "input", "hr", "img"}
OPTIONAL = {"li", "dt", "dd", "tr", "td", "th", "thead", "tbody", "p"}


class Reader(HTMLParser):
    """Collect elements and texts; `wrong` lists closing tags of elements that aren't open."""

    def __init__(self):
        super().__init__()
        self.elements, self.open, self.wrong, self.texts = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        while self.open and self.open[-1] != tag and self.open[-1] in OPTIONAL:
            self.open.pop()
        if not self.open or self.open[-1] != tag:
            self.wrong.append((tag, self.getpos()))
        else:
            self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.texts.append(data)

    def all(self, tag):
        return [attrs for name, attrs in self.elements if name == tag]


def read(html):
    reader = Reader()
    reader.feed(html)
    reader.close()
    return reader


def page_of(folder):
    return write_report(folder, figures="none").read_text(encoding="utf-8")


def section(html, name):
    start = html.index(f'<section id="{name}"')
    return html[start : html.find('<section id="', start + 1)]


def folded(html, name):
    """Return the HTML of a folded part of a section."""
    start = html.index(f'<details class="part" id="{name}"')
    return html[start : html.find('<details class="part"', start + 1)]
