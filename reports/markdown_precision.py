"""The report's section on errors against time, from the measurement in the results folder."""

from __future__ import annotations

from ghostball.reports.markdown_parts import Drawn, figure_link, many, one_line, table_of
from ghostball.reports.precision_text import (
    LEAST_ERROR,
    LEGEND,
    best_text,
    order_text,
    reach_heading,
    reach_text,
)
from ghostball.reports.stored import stored_in
from ghostball.validation.bench import PrecisionMeasurement
from ghostball.validation.bench.precision import TARGETS
from ghostball.validation.results.store import Results

FIGURES = {
    "precision": "Largest rest error against the time of a run",
    "precision-work": "Largest rest error against the work of a run, the same on any machine",
}
_MEANS = """\
Each engine plays scenes whose end is known from closed forms or proofs, at steps that are halved
again and again. The error is the largest distance of a ball from where it truly ends: the median
over shots that begin at different parts of a step, with their whole range as bar. An engine without
a step is a point. An open marker had other collisions than the true ones.\
"""


def precision_section(results: Results, figures: Drawn) -> list[str]:
    """Return the parts of the section; none where the folder holds no measurement."""
    measured = stored_in(results, PrecisionMeasurement)
    if measured is None:
        return []
    environment = measured.environment
    rounds = many(measured.rounds, "round")
    where = f"Measured on {environment['cpu']}, {environment['date']}, {rounds}."
    notes = ["This measurement was interrupted."] * measured.interrupted
    notes += ["This is a trial of few steps: its times mean nothing."] * measured.quick
    links = [figure_link(caption, figures.get(kind)) for kind, caption in FIGURES.items()]
    scenes = dict.fromkeys(point.scene for point in measured.points)
    return [
        "## What time buys",
        " ".join([_MEANS, where, *notes]),
        *links,
        LEGEND.replace("~", "\\~"),
        *(
            part
            for scene in scenes
            for part in (f"### Time to reach: {scene}", _table(measured, scene))
        ),
        _left_out(measured),
    ]


def _table(measured: PrecisionMeasurement, scene: str) -> str:
    header = ["engine", "order", *map(reach_heading, TARGETS), LEAST_ERROR, "its order"]
    rows = []
    for curve in (one for one in measured.curves if one.scene == scene):
        mine = [p for p in measured.points if (p.scene, p.engine) == (scene, curve.engine)]
        reached = [reach_text(one).replace("~", "\\~") for one in curve.reach]
        rows.append(
            [
                f"`{curve.engine}`",
                order_text(curve),
                *reached,
                best_text(mine),
                one_line(curve.order_note),
            ]
        )
    return table_of(header, rows)


def _left_out(measured: PrecisionMeasurement) -> str:
    return "\n".join(
        f"- {one.scene}, `{one.engine}` is left out: {one_line(one.why)}"
        for one in measured.left_out
    )
