"""Write the report of a stress run: `stress.md` with its figures, from what is stored alone."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from ghostball.engine import GhostballError
from ghostball.reports import style
from ghostball.reports.stress_figures import FIGURES
from ghostball.reports.words import (
    Drawn,
    figure_link,
    harmless_markdown,
    many,
    one_line,
    table_of,
)
from ghostball.validation.results.files import write_whole
from ghostball.validation.stress import FAMILIES, StressFolder
from ghostball.validation.stress.survival import Survival, all_survival, survival_of, trying_again
from ghostball.validation.stress.tracked import (
    COUNTS,
    DEPTH,
    QUANTILES,
    SPEED,
    largest_step,
    storm_counts,
    storm_quantiles,
)

REPORT = "stress.md"
FOLDER = "figures"

_FIGURE_TEXTS = {
    "miss-rate": (
        "Miss rate against depth",
        "A path that is a small part of a diameter too deep to miss, or too far to hit. An engine "
        "that only looks where its steps end passes over shallow hits.",
    ),
    "energy": (
        "Energy error against steps and collisions",
        "How far the energy is from the right one, over the first: at the end of a shot, against "
        "the step, and along a gas, against its collisions. What is exactly right is drawn at "
        "1e-17; a level line is an engine that has no step.",
    ),
    "equation-of-state": (
        "Equation of state of hard discs",
        "The pressure of elastic gases, from their collisions, against the literature's. Bars are "
        "standard errors.",
    ),
    "storms": (
        "Events of random breaks",
        "Part of all breaks that need at least as many events, contact steps of balls that press "
        "each other, and seconds.",
    ),
    "cliffs": (
        "Largest step without a miss",
        "From every start phase tried, at this step and at all shorter ones of the ladder. "
        "An engine that isn't shown has no step.",
    ),
}
"""Heading of each figure's section, and what it shows."""


def write_stress_report(path: str | Path) -> Path:
    """Write `stress.md` and `figures/` into the folder of a stress run.

    Parameters
    ----------
    path : path
        A folder that `ghostball stress` wrote.

    Returns
    -------
    Path
        The report, replaced only once every figure is there.

    Raises
    ------
    GhostballError
        Where the folder holds no stress run, or nothing can be written.
    """
    folder = StressFolder.load(path)
    try:
        drawn = _draw(folder)
        report = folder.path / REPORT
        write_whole(report, harmless_markdown(report_text(folder, drawn)))
    except OSError as error:
        raise GhostballError(
            f"{error.filename or folder.path}: can't write the report: {error.strerror or error}. "
            "Copy the folder to where it can be written, and report on that"
        ) from error
    return report


def _draw(folder: StressFolder) -> Drawn:
    """Draw what the run has data for; figures of an earlier report go."""
    drawn = {}
    place = folder.path / FOLDER
    place.mkdir(exist_ok=True)
    for name, draw in FIGURES.items():
        stem = PurePosixPath(FOLDER, name)
        with style.drawing():
            figure = draw(folder)
            if figure is not None:
                style.save_figure(figure, folder.path / stem)
                drawn[name] = stem
        if figure is None:
            for ending in style.FORMATS:
                (place / f"{name}.{ending}").unlink(missing_ok=True)
    return drawn


def report_text(folder: StressFolder, drawn: Drawn) -> str:
    """Return the report as Markdown."""
    parts = ["# Stress: what engines survive", about_text(folder)]
    parts += ["## Survival", survival_table(folder)]
    for name, (heading, text) in _FIGURE_TEXTS.items():
        if name in drawn:
            parts += [f"## {heading}", text, figure_link(heading, drawn[name])]
            parts += {"storms": _storms, "cliffs": _cliffs}.get(name, _nothing)(folder)
    parts += worst_cases(folder)
    parts += ["## What is asked", *_asked(folder)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _nothing(folder: StressFolder) -> list[str]:  # noqa: ARG001
    return []


def about_text(folder: StressFolder) -> str:
    """Return which run it is, how much of it is done, where and when."""
    run = folder.run
    environment = run.environment
    done = many(len(folder.findings), "trial")
    text = f"Suite `{run.suite}`, {done} of {folder.planned} on {many(len(run.labels), 'engine')}, "
    text += f"{environment.get('cpu', 'unknown machine')}, {str(environment.get('date', ''))[:10]}."
    if not folder.whole:
        text += " **This run is not whole**: what is missing was not come to."
    return one_line(text)


def survival_table(folder: StressFolder) -> str:
    """Return what each engine survived, by family."""
    labels = folder.run.labels
    rows = []
    for family in folder.run.families:
        cells = [_cell(survival_of(folder, family, label)) for label in labels]
        rows.append([_title(family), *cells])
    header = ["survived / tried", *(f"`{one_line(label)}`" for label in labels)]
    note = (
        "Trials that an engine can't represent are not counted; a dash says that none is left. A "
        "trial is survived where all of its shots are."
    )
    return "\n\n".join([table_of(header, rows), note])


def _cell(one: Survival) -> str:
    return f"**{one.text}**" if one.broken or one.failed else one.text


def _title(family: str) -> str:
    known = FAMILIES.get(family)
    return family if known is None else known.title


def worst_cases(folder: StressFolder) -> list[str]:
    """Return the worst case of each family and engine that broke, and how to see it again."""
    rows = [
        [
            _title(one.family),
            f"`{one_line(one.label)}`",
            f"{one.broken_shots} of {one.shots}",
            one_line(f"`{worst.trial}`: {worst.faults[0] if worst.faults else ''}"),
            _command(one.command(folder.path)),
            _command(one.again(folder)),
        ]
        for one in all_survival(folder)
        if one.broken and (worst := one.breaks()[0] if one.worst is None else one.worst)
    ]
    failed = _not_judged(folder)
    if not rows:
        return [*failed, "## Worst cases", "Nothing broke."]
    header = [
        "family",
        "engine",
        "shots that broke",
        "worst case",
        "seen again by",
        "judged again by",
    ]
    return [*failed, "## Worst cases", table_of(header, rows)]


def _command(command: str | None) -> str:
    return "" if command is None else f"`{one_line(command)}`"


def _not_judged(folder: StressFolder) -> list[str]:
    """Return what the harness failed to judge, of which nothing is known."""
    rows = [
        [
            _title(one.family),
            f"`{one_line(one.label)}`",
            one_line(f"`{failed.trial}`: {failed.faults[0]}"),
            _command(trying_again(failed, folder)),
        ]
        for one in all_survival(folder)
        for failed in one.failures()
    ]
    header = ["family", "engine", "why", "tried again by"]
    return ["## Not judged", table_of(header, rows)] if rows else []


def _storms(folder: StressFolder) -> list[str]:
    """Return the quantiles of what breaks need."""
    rows = []
    for label in folder.run.labels:
        counts, quantiles = storm_counts(folder, label), storm_quantiles(folder, label)
        if counts is None or quantiles is None:
            continue
        for name, text in COUNTS.items():
            cells = [
                style.format_time(x) if name == "seconds" else f"{x:.0f}"
                for x in quantiles[name].values()
            ]
            rows.append([f"`{one_line(label)}`", str(len(counts[name])), text, *cells])
    return [table_of(["engine", "breaks", "", *QUANTILES], rows)]


def _cliffs(folder: StressFolder) -> list[str]:
    """Return the largest step of each engine in one shot, to be tracked."""
    rows = []
    for label in folder.run.labels:
        one = largest_step(folder, label)
        if one is None:
            continue
        text = "none of the ladder" if one.largest is None else style.format_time(one.largest)
        own = style.format_time(one.own)
        rows.append([f"`{one_line(label)}`", own, text if one.is_cliff else f"at least {text}"])
    if not rows:
        return []
    shot = f"{SPEED:g} m/s, {DEPTH:g} diameters deep"
    return [table_of(["engine", "own step", f"no miss up to ({shot})"], rows)]


def _asked(folder: StressFolder) -> list[str]:
    known = [FAMILIES[name] for name in folder.run.families if name in FAMILIES]
    return ["\n".join(f"- **{family.title}** (`{family.name}`): {family.asks}" for family in known)]
