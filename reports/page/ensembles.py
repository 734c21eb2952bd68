"""How perturbed shots end on each engine, with the figures that were drawn of it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.page.rendering import render
from ghostball.reports.words import many
from ghostball.validation.ensembles import (
    QUANTITIES,
    REFERENCE,
    Compared,
    Comparison,
    EnsembleRecord,
    Ensembles,
    compare,
)
from ghostball.validation.ensembles.compare import LEVEL
from ghostball.validation.results.store import Results

Pictures = Mapping[str, PurePosixPath]
"""PNG files that were drawn, by their name without the ending, relative to the page."""

REASONS_SHOWN = 3
"""How many members without an end are named for an engine; the others are counted."""


def ensembles_html(results: Results, drawn: Pictures) -> Markup:
    """Return how perturbed shots end on each engine; "" where none were run."""
    ensembles = Ensembles.load(results.path)
    if ensembles is None:
        return Markup()
    compared, run = compare(ensembles), ensembles.run
    here, there = (where.get("git") for where in (results.environment, run.environment))
    return render(
        "ensembles.html",
        run=run,
        position=style.format_length(run.size.position),
        reference=REFERENCE,
        permutations=compared.permutations,
        tests=sum(one.test is not None for one in compared.comparisons),
        level=LEVEL,
        certified=any(one.engine == "certified" for one in ensembles.records),
        null=compared.null.sentence,
        other_code=here != there,
        quantities=QUANTITIES.values(),
        scenes=[
            {
                "name": scene,
                "rows": list(_rows(ensembles, compared, scene)),
                "remarks": list(_remarks(ensembles, scene)),
                "picture": _data(results.path, drawn.get(f"{scene}-ensemble")),
            }
            for scene in run.scenes
            if ensembles.of(scene)
        ],
    )


def effect_text(one: Comparison) -> str:
    """Return how large a difference is, or a dash where there was no test."""
    return "–" if one.test is None else f"{one.test.effect:.2f}"


def without_end_text(record: EnsembleRecord) -> str:
    """Say how many members of an ensemble came to no end, and of the first few why; "" if none."""
    said = []
    for verb, members in (("failed", record.failed), ("stopped early", record.stopped)):
        if members:
            reasons = list(dict.fromkeys(members.values()))
            more = len(reasons) - REASONS_SHOWN
            listed = "; ".join(reasons[:REASONS_SHOWN]) + (f"; {more} more" if more > 0 else "")
            said.append(f"{many(len(members), 'member')} {verb}: {listed}")
    return ". ".join(said)


def _rows(ensembles: Ensembles, compared: Compared, scene: str) -> Iterator[dict[str, Any]]:
    """Yield what the table of a scene says of each engine, other members of ours first."""
    streams = [(True, record) for record in ensembles.of(scene, "null").values()]
    streams += [(False, record) for record in ensembles.of(scene).values()]
    for null, record in streams:
        if found := compared.of(scene, record.label, record.stream):
            rest = found[0]
            yield {
                "label": record.label,
                "null": null,
                "ended": f"{rest.ended} of {ensembles.run.count}",
                "distance": "–" if rest.test is None else style.format_length(rest.test.distance),
                "cells": [(_cell(one), one.differs) for one in found],
                "differs": _differs(found),
            }


def _differs(found: Sequence[Comparison]) -> str:
    """Say what differs, that nothing does, or that none could show."""
    names = [QUANTITIES[one.quantity] for one in found if one.differs]
    judged = all(one.judged for one in found)
    return ", ".join(names) or ("nothing" if judged else "not judged: too few members")


def _cell(one: Comparison) -> str:
    if one.test is None or one.p is None:
        return "–"
    p = "1" if one.p >= 0.995 else f"{one.p:.2g}"
    return f"{effect_text(one)} ({one.test.chance:.2f}), p {p}"


def _remarks(ensembles: Ensembles, scene: str) -> Iterator[tuple[str, str]]:
    """Yield each engine that did not run, or whose members did not all end, and why."""
    for record in [*ensembles.of(scene).values(), *ensembles.of(scene, "null").values()]:
        unable = f"{record.outcome.replace('-', ' ')}: {record.reason}"
        text = without_end_text(record) if record.outcome == "ran" else unable
        if text:
            yield record.label, text


def _data(folder: Path, picture: PurePosixPath | None) -> str:
    """Return a picture as it lies within the page, which may be sent without its folder."""
    return "" if picture is None else b64encode((folder / picture).read_bytes()).decode()
