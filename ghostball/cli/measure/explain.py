"""`ghostball explain`: find the cause of an engine's error, and print or draw the explanation."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import typer
from numpy.typing import NDArray
from pydantic_core import to_json
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ghostball.cli.measure.commands import ExplainOptions
from ghostball.cli.options import TextOrJson
from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.single_shots import (
    check_plot,
    compile_first,
    engine_process,
    status_of,
)
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import busy, stdout
from ghostball.model import Status, energy_of, initial_state
from ghostball.reference_adapters import make_engine
from ghostball.reports import plot_explanation, style
from ghostball.reports.reason import reason_of
from ghostball.validation.diagnose.attribution import Attribution, Rung
from ghostball.validation.diagnose.explanation import Explanation, explain
from ghostball.validation.diagnose.margins import Margin
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.grading.event_logs import Event
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.results.store import Results, has_results
from ghostball.validation.scenes.library import find_scene

FEW_ULPS = 1e6
"""A length below this number of ulps [1], about 0.1 nm, is also printed in units of rounding."""

BARS = 44
"""Width of the bar chart [columns]."""

LEVELS = " ▁▂▃▄▅▆▇█"

REFERENCES = {
    "certified": "the certified result",
    "closed form": "the closed-form rest positions, with the motion from Ghostball's engine",
    "integration": "an integration in 40 digits, which is not certified",
    "our engine": "Ghostball's own engine, which is not an independent reference",
}
"""The kinds of reference results, in words."""

RUN_NAMES = {"truth": "in the reference", "engine": "in {label}"}


def run(asked: ExplainOptions) -> ExitStatus:
    """Simulate, compare, print and draw the explanation; return the exit status.

    Raises `typer.BadParameter` if no engine or scene can be chosen, or if the picture can't be
    written.
    """
    plot, engine = asked.plot, asked.engine
    check_plot(plot)
    config = load_config()
    if engine is None:
        if not config.engines:
            raise typer.BadParameter(
                "must be given, because no [tool.ghostball] names an engine. Name one, such as `-e "
                "my_module:simulate`",
                param_hint="--engine",
            )
        engine = config.engines[0]
    made = make_engine(engine)
    shot = find_scene(_worst_scene(config.out, engine) if asked.scene is None else asked.scene)
    compile_first([shot], engine)
    what = "runs with three time steps" if asked.attribute else "one run"
    with (
        busy(f"explaining {shot.name} on {engine}: the reference, and {what}"),
        engine_process(made, asked.time_limit) as playing,
    ):
        explanation = explain(shot, playing, label=engine, attributed=asked.attribute)
    if plot is not None:
        with busy(f"drawing {plot}"):
            plot_explanation(explanation, plot)
    if asked.form is TextOrJson.JSON:
        # JSON has no NaN or infinity, which an unstable engine can return: they become null.
        print(to_json(explanation.to_dict(), inf_nan_mode="null").decode())
    else:
        console = stdout()
        for part in parts_of(explanation):
            console.print(part)
        if plot is not None:
            console.print(f"drawn in {plot}", soft_wrap=True, markup=False)
    return status_of(explanation.result, made.name)


def _worst_scene(folder: Path, engine: str) -> str:
    """Return the scene of the last run with the worst result of an engine.

    Scenes that fail a limit come first, then the worst accuracy class, then the largest error.

    Raises `typer.BadParameter` if the folder holds no result of the engine.
    """
    cases = Results.open(folder).cases if has_results(folder) else ()
    ran: list[tuple[bool, int, float, str]] = []
    for case in cases:
        found = case.accuracy
        if case.label == engine and found is not None:
            right = -ACCURACY_KINDS.index(found.kind), -(found.error or 0.0)
            ran.append((case.passed is not False, *right, case.scene))
    if not ran:
        raise typer.BadParameter(
            f"must be given: {folder} holds no result of {engine} to take the worst scene from",
            param_hint="SCENE",
        )
    return min(ran)[-1]


def parts_of(explanation: Explanation) -> Iterator[RenderableType]:
    """Yield the printed parts of an explanation, in order."""
    known = explanation.known
    heading = Text(explanation.scene.name, style="bold")
    reference = REFERENCES[known.kind]
    heading.append(f" on {explanation.label}, compared with {reference}", style="not bold")
    if known.why:
        heading.append(f" (not certified: {known.why})", style="dim not bold")
    yield heading
    yield Text()
    if reason := reason_of(explanation):
        yield Text(reason, style="bold")
        yield Text()
    yield _picture(explanation)
    yield Text()
    if explanation.parting is None:
        yield from _agreement_lines(explanation)
    else:
        yield from _wrong_collision_lines(explanation)
    if explanation.attribution is not None:
        yield Text()
        yield Text("Cause of the error", style="bold")
        yield _attribution_table(explanation.attribution)


def _picture(explanation: Explanation) -> RenderableType:
    """Return bar charts of the largest error over time, and of the error with the factor fixed."""
    end, factor = explanation.result.rest_time, explanation.factor
    end = end if factor is None else factor.until
    times = np.linspace(0.0, end, BARS)
    if factor is None:
        off = explanation.distances(times)
        most = float(np.max(off))
        rows = [("error", off, most)]
    else:  # errors of the run in which the factor was found
        t, before, after = np.array(factor.curve).T
        most = factor.before
        rows = [("error", np.interp(times, t, before), most)]
        rows.append(("remaining error", np.interp(times, t, after), factor.after))
    lines = [
        f"  {name:<15} {_bars(values, most)} up to {style.format_length(largest)}"
        for name, values, largest in rows
    ]
    return Text("\n".join([*lines, f"{'':18}0 s{style.format_time(end):>{BARS - 3}}"]))


def _bars(values: NDArray[np.float64], most: float) -> str:
    """Return a bar for each value; the bar of the value `most` has full height."""
    shares = values / most if most > 0.0 else values
    return "".join(LEVELS[round(float(share) * (len(LEVELS) - 1))] for share in shares.clip(0, 1))


def _agreed(explanation: Explanation) -> str:
    count = len(explanation.agreement.before)
    if not count:
        return "No right collision comes before the first wrong one"
    text = "1 collision agrees" if count == 1 else f"{count} collisions agree"
    if explanation.parting is not None:
        text = f"Before the first wrong collision, {text}"
    latest = explanation.latest
    assert latest is not None
    event, late = latest
    return f"{text}. Largest time error: {event.describe(explanation.scene)} {_late(late)}"


def _late(seconds: float) -> str:
    if seconds == 0.0:
        return "at the same instant"
    return f"{style.format_time(abs(seconds))} {'late' if seconds > 0.0 else 'early'}"


def _agreement_lines(explanation: Explanation) -> Iterator[RenderableType]:
    yield Text("Every ball has the collisions of the reference.")
    if explanation.agreement.pairs:
        yield Text(f"{_agreed(explanation)}.")
    if not explanation.result.status.complete:
        return  # the final state isn't a rest position
    distances = explanation.rest_distances
    ball = int(distances.argmax())
    late = explanation.rest_time_difference
    rests = explanation.result.status is Status.REST
    yield Text(
        f'Largest error at the end: "{explanation.scene.balls[ball].id}", '
        f"{style.format_length(float(distances[ball]))}"
        + (f"; the last ball rests {_late(late)}." if rests else ".")
    )
    energies = [
        float(energy_of(explanation.scene, state).total[0])
        for state in (
            initial_state(explanation.scene),
            explanation.known.result.final_state,
            explanation.result.final_state,
        )
    ]
    if energies[1] > 1e-12 * energies[0]:
        yield Text(
            f"Energy at the end: {energies[2]:.6g} J; in the reference {energies[1]:.6g} J; "
            f"at the start {energies[0]:.6g} J."
        )


def _wrong_collision_lines(explanation: Explanation) -> Iterator[RenderableType]:
    parting = explanation.parting
    assert parting is not None
    yield Text(f"{_agreed(explanation)}.")
    yield Text(f"The first wrong collision, at t = {parting.t:.9g} s:", style="bold")
    table = Table(box=None, show_header=False, padding=(0, 2))
    other = explanation.label
    table.add_row("  reference", _event_text(explanation, parting.true))
    table.add_row(f"  {other}", _event_text(explanation, parting.other))
    yield table
    yield Text("Margins:")
    for margin in _useful_margins(explanation):
        yield Text(f"  {_margin_text(explanation, margin)}")
    yield Text("The balls at that time:")
    yield _balls_table(explanation)


def _useful_margins(explanation: Explanation) -> list[Margin]:
    """Return the smallest margin, and the other margins below a ball's diameter."""
    ball = 2.0 * float(explanation.scene.radii.max())
    smallest, others = explanation.margins[:1], explanation.margins[1:]
    return [*smallest, *(one for one in others if one.length < ball)]


def _event_text(explanation: Explanation, one: Event | None) -> str:
    if one is None:
        return "no further collision"
    return f"{one.describe(explanation.scene)} at t = {one.t:.9g} s"


def _margin_text(explanation: Explanation, margin: Margin) -> str:
    where = RUN_NAMES[margin.run].format(label=explanation.label)
    event = margin.event.describe(explanation.scene)
    length = style.format_length(margin.length)
    if margin.ulps < FEW_ULPS:
        length += f" ({margin.ulps:.2g} times the rounding of a position)"
    if margin.what == "miss":
        return f"{where}, {event}: shifting the path by {length} would make it miss"
    if margin.what == "collision":
        scene = explanation.scene
        first, what = margin.event.first_ball(scene), margin.event.obstacle(scene)
        return f"{where}, the smallest gap between {first} and {what} is {length}"
    assert margin.seconds is not None
    return (
        f"{where}, {event} {style.format_time(margin.seconds)} before the collision in the other "
        f"run; {length} more distance would reverse the order"
    )


def _balls_table(explanation: Explanation) -> Table:
    vectors_of = (
        "reference\nx, y [m]",
        "engine\nx, y [m]",
        "reference\nvelocity [m/s]",
        "engine\nvelocity [m/s]",
    )
    heads = ("ball", "distance", *map(escape, vectors_of))
    rows = []
    for one in explanation.states:
        vectors = (one.true_position, one.position, one.true_velocity, one.velocity)
        shown = (f"{x:.3f}, {y:.3f}" for x, y in vectors)
        rows.append((escape(one.ball), style.format_length(one.distance), *shown))
    return table_of(heads, rows, right=heads[1:], whole=())


def _attribution_table(found: Attribution) -> RenderableType:
    table = Table(box=None, show_header=False, padding=(0, 2))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    if found.difference is not None:
        at = "the end" if found.instant is None else style.format_time(found.instant)
        why = f" ({found.until})" if found.until else ""
        table.add_row("error", f"{style.format_length(found.difference)} at {at}{why}")
    for k, one in enumerate(found.ladder):
        step = style.format_time(one.step)
        if one.difference is None:
            text = f"{_collision_errors(one)} with a time step of {step}"
            table.add_row("" if k else "collisions", text)
        elif k:
            table.add_row("", f"{style.format_length(one.difference)} with a time step of {step}")
    if found.with_exact_steps is not None:
        table.add_row(
            "", f"{style.format_length(found.with_exact_steps)} with `contact_steps=exact`"
        )
    table.add_row("cause", escape(found.reason or _CAUSES[found.outcome]))
    if found.outcome == "model" and not found.ladder:
        table.add_row("", "the engine has no time step to shorten")
    if found.rounding is not None:
        table.add_row("rounding", f"moves a ball by {style.format_length(found.rounding)} at most")
    if found.approximations:
        table.add_row("approximates", escape("\n".join(found.approximations)))
    return table


def _collision_errors(one: Rung) -> str:
    """Return the largest error of the collision times in a run, and the first wrong collision."""
    late = "no collision is common to all runs"
    if one.late is not None:
        late = f"time errors up to {style.format_time(one.late)}"
    wrong = "no wrong collision"
    if one.wrong_from is not None:
        wrong = f"first wrong collision at {style.format_time(one.wrong_from)}"
    return f"{late}; {wrong},"


_CAUSES = {
    "step": "the engine's time step: with a shorter one the error shrinks",
    "model": "the engine's model: its physics",
    "rounding": "rounding",
    "agrees": "no error as far as the shot can be compared",
    "unseparated": "time step and model can't be separated",
}
"""Causes of an error, in words."""
