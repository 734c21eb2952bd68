"""Find the line of a field in a TOML text.

The parser of the standard library keeps no positions.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator

Location = tuple[int | str, ...]
"""Keys and indices from the top of a document down to a field."""

_KEY = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|'[^']*')"""
_DOTTED = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_DOTTED})\s*\]\]?\s*(?:#.*)?$")
_ASSIGNMENT = re.compile(rf"\s*({_DOTTED})\s*=")
_TOKEN = re.compile(r'''"""|\'\'\'|"(?:[^"\\]|\\.)*"|'[^']*'|[][{}#]''')
_END_OF_STRING = {'"""': re.compile(r'(?<!\\)(?:\\\\)*"""+'), "'''": re.compile(r"'''+")}


def line_of(text: str, location: Location) -> int | None:
    """Return the line of a field, or the first line of the nearest part around it.

    Lines count from 1. None if not even the outermost part is in `text`. `text` is valid TOML.
    """
    best, depth = None, 0
    for number, path in _keys_by_line(text):
        # A dotted key may be deeper than the wrong field.
        shared = 0
        for part, sought in zip(path, location, strict=False):
            if part != sought:
                break
            shared += 1
        if shared > depth:
            best, depth = number, shared
    return best


def _keys_by_line(text: str) -> Iterator[tuple[int, Location]]:
    """Yield the lines that start with a table header or a key, and the location of each.

    The content of an inline table belongs to the line of its key.
    """
    section: Location = ()
    last: dict[Location, int] = {}  # index of the newest table of each array of tables
    string, depth = "", 0
    for number, line in enumerate(text.split("\n"), start=1):
        begins = not string and depth == 0
        if begins and (header := _HEADER.match(line)):
            keys = _keys(header[2])
            section = ()
            for i, key in enumerate(keys, start=1):
                section += (key,)
                if header[1] == "[[" and i == len(keys):
                    last[section] = last.get(section, -1) + 1
                if section in last:
                    section += (last[section],)
            yield number, section
            continue
        if begins and (assignment := _ASSIGNMENT.match(line)):
            yield number, section + _keys(assignment[1])
        string, depth = _open_after(line, string, depth)


def _keys(dotted: str) -> tuple[str, ...]:
    if '"' not in dotted and "'" not in dotted:
        return tuple(key.strip() for key in dotted.split("."))
    keys: tuple[str, ...] = ()
    table = tomllib.loads(f"{dotted} = 0")
    while isinstance(table, dict):
        ((key, table),) = table.items()
        keys += (key,)
    return keys


def _open_after(line: str, string: str, depth: int) -> tuple[str, int]:
    """Return the open multi-line string's delimiter, or "", and the bracket depth after a line."""
    at = 0
    while True:
        if string:
            end = _END_OF_STRING[string].search(line, at)
            if end is None:
                return string, depth
            at, string = end.end(), ""
        token = _TOKEN.search(line, at)
        if token is None or token[0] == "#":
            return "", depth
        at = token.end()
        if token[0] in _END_OF_STRING:
            string = token[0]
        else:
            depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(token[0], 0)
