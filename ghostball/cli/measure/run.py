"""`ghostball run`: simulate one scene on one engine, and print the rest positions."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import typer
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.text import Text

from ghostball.cli.measure.commands import RunOptions
from ghostball.cli.measure.run_starts import play_starts
from ghostball.cli.options import RecordChoice, TextOrJson
from ghostball.cli.shared.calls import refuse_given
from ghostball.cli.shared.single_shots import (
    check_plot,
    compile_first,
    engine_process,
    status_of,
)
from ghostball.cli.shared.tables import facts_table, table_of
from ghostball.cli.shared.terminal import busy, say, stdout
from ghostball.model import EventKind, Result, partner_name
from ghostball.model.strokes import StruckBall, struck_balls
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.registry import OURS
from ghostball.reports import plot_result
from ghostball.reports.plot import is_film
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.scenes.library import find_scene

_HASH = re.compile("[0-9a-f]{64}")


def run(asked: RunOptions) -> ExitStatus:
    """Simulate, print and draw the result, and return the exit status.

    Raises `typer.BadParameter` if options contradict each other.
    """
    if asked.starts is not None:
        return play_starts(asked, asked.starts)
    refuse_given(asked.context, "the option needs `--starts`", "shard", "out", "cluster")
    record, plot, expect_hash = asked.record, asked.plot, asked.expect_hash
    if plot is not None:
        if record not in (None, RecordChoice.TRAJECTORY):
            raise typer.BadParameter(
                f"--plot needs --record trajectory, got {record.value}", param_hint="--record"
            )
        record = RecordChoice.TRAJECTORY
        check_plot(plot, films=True)
    if expect_hash is not None:
        expect_hash = expect_hash.strip().lower()
        if not _HASH.fullmatch(expect_hash):
            raise typer.BadParameter(
                f"must be 64 hexadecimal digits, got {expect_hash!r}. `ghostball run {asked.scene} "
                "--record events` prints the hash",
                param_hint="--expect-hash",
            )
        if record is RecordChoice.REST:
            raise typer.BadParameter(
                "--expect-hash needs --record events, got rest", param_hint="--record"
            )
        record = record or RecordChoice.EVENTS
    made = make_engine(asked.engine)
    shot = find_scene(asked.scene)
    if record is None and shot.table is not None and shot.table.holes:
        record = RecordChoice.EVENTS  # the events tell which balls were pocketed
    compile_first([shot] if made.name == OURS else [], asked.engine)
    with busy(f"{shot.name} on {asked.engine}"), engine_process(made, asked.time_limit) as playing:
        result = run_engine(playing, shot, (record or RecordChoice.REST).value)
    if plot is not None:
        with busy(f"{'filming' if is_film(plot) else 'drawing'} {plot}"):
            plot_result(result, plot)
    if asked.form is TextOrJson.JSON:
        typer.echo(result.to_json())
    else:
        stdout().print(result_table(result))
        if plot is not None:
            what = "film" if is_film(plot) else "picture"
            stdout().print(f"{what}: {plot}", soft_wrap=True, markup=False)
    return status_of(result, made.name) or _compare_hash(result, expect_hash)


def _compare_hash(result: Result, expected: str | None) -> ExitStatus:
    found = result.to_dict()["hash"]
    if expected in (None, found):
        return ExitStatus.PASSED
    say(
        f"[bold red]hash differs:[/] {escape(result.scene.name)} on {escape(result.engine)} has "
        f"{found}, expected {expected}"
    )
    return ExitStatus.CHECK_FAILED


def result_table(result: Result) -> RenderableType:
    """Return the table of rest positions, and below it facts about the run."""
    scene = result.scene
    flight = scene.physics.airborne
    quantities = ("x", "y", "z", "moved") if flight else ("x", "y", "moved")
    heads = [escape(f"{quantity} [m]") for quantity in quantities]
    moved = np.linalg.norm(result.rest_positions - scene.positions, axis=1)
    rows = (
        (escape(ball.id), *(f"{x:.9f}" for x in place[: 3 if flight else 2]), f"{way:.6f}")
        for ball, place, way in zip(scene.balls, result.rest_positions, moved, strict=True)
    )
    balls = table_of(("ball", *heads), rows, right=heads)
    heading = Text(scene.name, style="bold").append(f"  {scene.title}", style="not bold")
    return Group(heading, balls, facts_table(_outcome(result)))


def _outcome(result: Result) -> dict[str, str]:
    energy = result.to_dict()["energy"]
    status = result.status.value + (f": {result.reason}" if result.reason else "")
    settings = ", ".join(f"{key}={value}" for key, value in result.settings.items())
    rows = _strokes(result) | {
        "engine": f"{result.engine} {settings}".strip(),
        "ended": f"at t = {result.rest_time:.9f} s, {status}",
        "collisions": _pairs(result.collision_counts),
        "energy": f"{energy['initial']:.6g} J at the start, {energy['final']:.6g} J at the end",
        "work": _pairs({name: count for name, count in result.work.items() if count}),
        "run time": _run_time(result),
    }
    if result.events is not None:
        if pocketed := _pocketed(result):
            rows["pocketed"] = pocketed
        rows["events"] = f"{len(result.events)} recorded; `--format json` prints them"
        rows["hash"] = result.to_dict()["hash"]
    return rows


def _run_time(result: Result) -> str:
    if result.engine_time is None:
        return f"{result.wall_time * 1e3:.3f} ms"
    inside = f"{result.engine_time * 1e3:.3f} ms in the engine's own steps"
    return f"{result.wall_time * 1e3:.3f} ms, {inside}"


def _pocketed(result: Result) -> str:
    """Return the pocketed balls, each with its pocket, in order of time."""
    assert result.events is not None
    events = result.events[result.events["kind"] == EventKind.POCKETED]
    return ", ".join(
        f"{result.scene.balls[a].id} ({partner_name(EventKind.POCKETED, b)})"
        for a, b in zip(events["a"].tolist(), events["b"].tolist(), strict=True)
    )


def _strokes(result: Result) -> dict[str, str]:
    """Return facts about each strike of the scene, and about the motion that it starts."""
    rows = {}
    for struck in struck_balls(result.scene):
        rows[f"strike of {struck.ball.id}"] = _strike_text(struck)
        rows[f"{struck.ball.id} starts with"] = _start_text(struck)
    return rows


def _strike_text(struck: StruckBall) -> str:
    strike = struck.strike
    offsets = _sided(strike.offset_left, "radii", "to the left", "to the right")
    offsets += _sided(strike.offset_up, "radii", "up", "down")
    aim = f"{strike.speed:.6g} m/s in the direction {_angle(strike.direction)}"
    where = f"hit {' and '.join(offsets) or 'at the centre'}"
    return f"{aim}, elevated by {_angle(strike.elevation)}, {where}"


def _start_text(struck: StruckBall) -> str:
    wx, wy, wz = struck.ball.angular_velocity or (0.0, 0.0, 0.0)
    turned = math.degrees(struck.squirt_angle)
    squirt = _sided(round(turned, 3), "degrees", "to the left", "to the right")
    parts = [
        f"{struck.ball.speed:.6g} m/s",
        f"spin ({wx:.4g}, {wy:.4g}, {wz:.4g}) rad/s",
        f"squirt {squirt[0] if squirt else 'none'} ({struck.strike.squirt})",
        *_sided(-struck.tip_velocity[2], "m/s", "into the table", "up, off the tip"),
    ]
    return ", ".join(parts) + f"; the cue then moves at {struck.cue_speed:.4g} m/s"


def _angle(radians: float) -> str:
    return f"{math.degrees(radians):.5g} degrees ({radians:.6g} rad)"


def _sided(value: float, unit: str, positive: str, negative: str) -> list[str]:
    """Return the magnitude and the direction of a signed value, [] for 0."""
    if value == 0.0:
        return []
    return [f"{abs(value):.4g} {unit} {positive if value > 0.0 else negative}"]


def _pairs(counts: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in counts.items()) or "none"
