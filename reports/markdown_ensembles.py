"""What the page says of ensembles, in Markdown, from those in the results folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ghostball.reports import style
from ghostball.reports.markdown_parts import many, one_line, table_of
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

REASONS_SHOWN = 3
"""How many members without an end are named for an engine; the others are counted."""

_MEANS = """\
Where a shot is too chaotic for two engines to agree on it, they may still agree on how such shots
end. Each scene is perturbed {count} times at random: the speed of each moving ball by up to
{velocity:g} of itself and its direction by up to {velocity:g} rad, x and y of each ball by up to
{position}, but never so that balls overlap or leave the table: touching balls are perturbed by
opening gaps alone. Every engine runs the same shots.

The distributions are compared with those of `{reference}`. **That is a comparison of codes, not
with truth**, and most differences are of the model: what an engine represents differently, or not
at all. *Effect* is the energy distance as a part of the most that it could be: 0 where the
distributions are the same, near 1 where they lie apart by far more than they are wide; in brackets
what it stays below by chance alone in 95 of 100 cases. With enough members every difference is
significant, so look at the effect first. p is by {permutations} permutations, corrected (Holm) for
all {tests} tests here; **bold** where it is below {level:g}. Rest positions are compared for all
balls jointly, their distance as root mean square over the balls; energy at five instants jointly,
as a part of the initial energy.\
"""


_CERTIFIED = "`certified` proves each of its shots: against those, it is a comparison with truth."


def ensembles_parts(results: Results) -> Iterator[tuple[str, str]]:
    """Yield what is said of all ensembles, under "", and of each scene's, under its name.

    Nothing where the folder holds no ensembles.
    """
    ensembles = Ensembles.load(results.path)
    if ensembles is None:
        return
    compared = compare(ensembles)
    run = ensembles.run
    parts = [
        _MEANS.format(
            count=run.count,
            velocity=run.size.velocity,
            position=style.format_length(run.size.position),
            reference=REFERENCE,
            permutations=compared.permutations,
            tests=sum(one.test is not None for one in compared.comparisons),
            level=LEVEL,
        ),
        _CERTIFIED if any(r.engine == "certified" for r in ensembles.records) else "",
        f"**Null test of `{REFERENCE}`** {compared.null.sentence}.",
        _state_text(results, ensembles),
    ]
    yield "", "\n\n".join(part for part in parts if part)
    for scene in run.scenes:
        if records := ensembles.of(scene):
            parts = [
                f"### Ensemble of {scene}",
                _table(ensembles, compared, scene),
                _remarks([*records.values(), *ensembles.of(scene, "null").values()]),
            ]
            yield scene, "\n\n".join(part for part in parts if part)


def effect_text(one: Comparison) -> str:
    """Return how large a difference is, or a dash where there was no test."""
    return "–" if one.test is None else f"{one.test.effect:.2f}"


def unable_text(record: EnsembleRecord) -> str:
    """Say why an ensemble did not run; "" where it did."""
    if record.outcome == "ran":
        return ""
    return f"{record.outcome.replace('-', ' ')}: {record.reason}"


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


def _state_text(results: Results, ensembles: Ensembles) -> str:
    """Say whether the ensembles are whole, and when they were run where that was another run."""
    run = ensembles.run
    lines = []
    if run.state != "complete":
        why = "the run was interrupted"
        if run.state == "running":
            why = "the run is still running, or was killed"
        lines.append(f"> **These ensembles are not complete**: {why}.")
    here, there = (where.get("git") for where in (results.environment, run.environment))
    if here != there:
        lines.append(
            f"> These ensembles are of {run.environment.get('date', 'an unknown date')} and of "
            "another state of the code than the cases above."
        )
    return "\n".join(lines)


def _table(ensembles: Ensembles, compared: Compared, scene: str) -> str:
    header = [
        "engine",
        "ended",
        "rest positions: energy distance",
        *(f"{name}: effect, p" for name in QUANTITIES.values()),
        "differs in",
    ]
    streams = [("null", record) for record in ensembles.of(scene, "null").values()]
    streams += [("shots", record) for record in ensembles.of(scene).values()]
    rows = []
    for stream, record in streams:
        comparisons = compared.of(scene, record.label, record.stream)
        if not comparisons:
            continue
        rest = comparisons[0]
        differing = [QUANTITIES[one.quantity] for one in comparisons if one.differs]
        rows.append(
            [
                f"`{record.label}`" + (", other members (null test)" if stream == "null" else ""),
                f"{rest.ended} of {ensembles.run.count}",
                "–" if rest.test is None else style.format_length(rest.test.distance),
                *map(_cell, comparisons),
                ", ".join(differing) or _nothing_text(comparisons),
            ]
        )
    return table_of(header, rows) if rows else ""


def _nothing_text(comparisons: Sequence[Comparison]) -> str:
    """Say that there is no difference, or that none could show."""
    return "nothing" if all(one.judged for one in comparisons) else "not judged: too few members"


def _cell(one: Comparison) -> str:
    if one.test is None or one.p is None:
        return "–"
    text = f"{effect_text(one)} ({one.test.chance:.2f}), p {_p_text(one.p)}"
    return f"**{text}**" if one.differs else text


def _p_text(p: float) -> str:
    return "1" if p >= 0.995 else f"{p:.2g}"


def _remarks(records: list[EnsembleRecord]) -> str:
    """Return a line for each engine that did not run, or whose members did not all end."""
    return "\n".join(
        f"- `{record.label}`: {one_line(text)}"
        for record in records
        if (text := unable_text(record) or without_end_text(record))
    )
