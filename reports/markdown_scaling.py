"""The report's section on time per event, from the measurement in the results folder."""

from __future__ import annotations

from pathlib import PurePosixPath

from ghostball.reports import style
from ghostball.reports.markdown_parts import figure_link, many, one_line, table_of
from ghostball.reports.scaling_figure import NAMES, measured_scaling
from ghostball.validation.bench import ScalingMeasurement
from ghostball.validation.results.store import Results

CAPTION = "Time per event, against the number of balls and against their packing"
_MEANS = """\
Time of the simulation alone over the number of its events, median of the rounds. Engines take turns
on the same scenes; ours runs them for longer, since peers need so much more time. An event is a
collision of two balls, or of one with a cushion, and where balls slide also the start of rolling
and of rest. Times are those of this machine.\
"""


def scaling_section(results: Results, figure: PurePosixPath | None) -> list[str]:
    """Return the parts of the section; none where the folder holds no measurement."""
    measured = measured_scaling(results)
    if measured is None:
        return []
    environment = measured.environment
    rounds = many(measured.rounds, "round")
    where = f"Measured on {environment['cpu']}, {environment['date']}, {rounds}."
    notes = ["This measurement was interrupted."] * measured.interrupted
    notes += ["This is a trial at tiny sizes: its times mean nothing."] * measured.quick
    return [
        "## Time per event",
        " ".join([_MEANS, where, *notes]),
        figure_link(CAPTION, figure),
        _table(measured),
        _missing(measured),
    ]


def _table(measured: ScalingMeasurement) -> str:
    """Return time per event for few, and for the most balls that each engine was given."""
    rows = []
    for engine, physics in dict.fromkeys((p.engine, p.physics) for p in measured.by_balls):
        mine = [p for p in measured.by_balls if (p.engine, p.physics) == (engine, physics)]
        first, last = mine[0], mine[-1]
        rows.append(
            [
                f"`{engine}`",
                NAMES[physics],
                f"{style.format_time(first.per_event)} ({first.balls})",
                f"{style.format_time(last.per_event)} ({last.balls})",
            ]
        )
    header = ["engine", "physics", "time per event (fewest balls)", "(most balls)"]
    return table_of(header, rows) if rows else ""


def _missing(measured: ScalingMeasurement) -> str:
    """Say which engine lacks a curve, or ends early, and why."""
    return "\n".join(
        f"- `{curve.engine}`, {NAMES[curve.physics]}: "
        + ("" if curve.outcome == "ran" else f"{curve.outcome.replace('-', ' ')}: ")
        + one_line(curve.detail)
        for curve in measured.curves
        if curve.detail
    )
