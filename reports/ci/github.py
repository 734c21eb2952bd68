"""Notes that GitHub shows beside the lines of a pull request, and over the run of a workflow.

They are workflow commands: lines that a step prints, of the form
`::error file=NAME,line=N,title=TITLE::MESSAGE`.
"""

from __future__ import annotations

from collections.abc import Sequence

from ghostball.reports.findings import Finding

SHOWN = 10
"""GitHub shows so many errors of a step, and as many warnings; it drops the rest in silence."""


def notes(found: Sequence[Finding]) -> str:
    """Return findings as notes, as many as are shown; the last of each level counts the others."""
    lines = []
    for level in ("error", "warning"):
        these = [one for one in found if one.level == level]
        few = these if len(these) <= SHOWN else these[: SHOWN - 1]
        lines += [_command(one) for one in few]
        if rest := these[len(few) :]:
            titles = ", ".join(one.title for one in rest)
            lines.append(note(level, f"{len(rest)} more", titles))
    return "".join(f"{line}\n" for line in lines)


def note(level: str, title: str, message: str, place: str = "") -> str:
    """Return one note; `place` is "file=NAME,line=N", escaped, or ""."""
    properties = ",".join(filter(None, (place, f"title={_property(f'Ghostball: {title}')}")))
    return f"::{level} {properties}::{_data(message)}"


def _command(one: Finding) -> str:
    place = one.place
    where = "" if place is None else f"file={_property(place.file)},line={place.line}"
    return note(one.level, one.title, one.message, where)


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
