"""Tables of the documentation that are made from the code; each function returns Markdown."""

from __future__ import annotations

import inspect
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.fits import FitsMeasurement
from benchmarks.made import MadeMeasurement
from benchmarks.measurements import committed
from benchmarks.pictures.gallery import committed_board
from benchmarks.rebounds import ReboundsMeasurement
from benchmarks.synthetic_tracks import EXAMPLE_PHYSICS
from ghostball.engine import simulate
from ghostball.model import POOL_BALL_MASS, POOL_BALL_RADIUS, Ball, Physics, Strike, Table
from ghostball.model.features import Capability, Feature
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS
from ghostball.model.scene import stroke_of
from ghostball.reference_adapters import (
    ReferenceEngine,
    engine_class,
    engine_names,
    make_engine,
)
from ghostball.reports.accuracy import CLASSES
from ghostball.reports.board import about, cell_text, columns_of, looks_of, unit_of
from ghostball.reports.style import format_length, format_time
from ghostball.validation.board.board import Board
from ghostball.validation.board.column import FAULTS
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.measured.banks import through_points
from ghostball.validation.measured.best import best_cloth, best_cushion
from ghostball.validation.measured.cloth_families import deceleration
from ghostball.validation.measured.facts import Row, facts_of
from ghostball.validation.measured.oblique_hits import oblique_hit, throw_angle
from ghostball.validation.measured.rebounds import rebounds as measured_rebounds, square_rebound
from ghostball.validation.parallel.sources import PACKAGE_OF
from ghostball.validation.precision.points import PrecisionMeasurement
from ghostball.validation.scenes.library import select

NONE = Capability("none")

_PLAY = partial(simulate, record="trajectory")
_SYMBOLS = {"cushion_restitution": "e", "cushion_restitution_loss": "c"}


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (heads, ["---"] * len(heads), *rows)
    return "\n".join(" | ".join(cell.replace("|", "\\|") for cell in cells) for cells in lines)


def scenes() -> str:
    """Return the shipped scenes."""
    return _table(
        ("scene", "what it probes", "tags"),
        ((f"`{scene.name}`", scene.title, ", ".join(scene.tags)) for scene in select()),
    )


def fields(part: type[Ball | Physics | Strike | Table]) -> str:
    """Return the fields of a part of a scene: defaults and meaning."""
    rows = []
    for name, field in part.model_json_schema()["properties"].items():
        choices = [f"`{choice}`" for choice in field.get("enum", ())]
        default = field.get("default")
        meaning = field.get("description", "")
        rows.append(
            (
                f"`{name}`",
                "" if default is None else f"`{default}`",
                "; ".join(filter(None, (meaning, ", ".join(choices)))),
            )
        )
    return _table(("field", "default", "meaning"), rows)


def squirt() -> str:
    """Return the squirt of a level cue, seen from above, by offset and model."""
    shafts = (("end-mass", 0.0061), ("end-mass", 0.0098), ("end-mass", 0.0127))
    models = (*shafts, ("alciatore", 0.0098))
    rows = []
    for left, up in ((0.1, 0.0), (0.2, 0.0), (0.3, 0.0), (0.4, 0.0), (0.3, 0.3), (0.3, -0.3)):
        angles = []
        for model, end_mass in models:
            fields = {"offset_left": left, "offset_up": up, "squirt": model, "end_mass": end_mass}
            strike = Strike(speed=3.0, direction=0.0, **fields)
            x, y, _ = stroke_of(strike, POOL_BALL_RADIUS, POOL_BALL_MASS).velocity
            angles.append(f"{math.degrees(math.atan2(-y, x)):.2f}")
        rows.append((f"{left:g}", f"{up:g}", *angles))
    heads = (f"`{model}`, {1e3 * end_mass:g} g [degrees]" for model, end_mass in models)
    return _table(("`offset_left`", "`offset_up`", *heads), rows)


def metrics() -> str:
    """Return the metrics."""
    return _table(
        ("metric", "unit", "meaning", "measured against"),
        (
            (f"`{one.name}`", one.unit, one.meaning, one.compares or "nothing")
            for one in METRICS.values()
        ),
    )


def classes() -> str:
    """Return the classes of accuracy, from the best to the worst."""
    return _table(
        ("class", "what it says of a run"),
        ((f"**{kind}**", look.meaning) for kind, look in CLASSES.items()),
    )


def engines() -> str:
    """Return what each engine represents of each part of the physics."""
    marks = {"exact": "exact", "approximate": "nearly", "none": ""}
    shipped = {name: _made(name).capabilities for name in engine_names()}
    return _table(
        ("physics", *(f"`{name}`" for name in shipped)),
        (
            (
                feature.value,
                *(marks[known.get(feature, NONE).support] for known in shipped.values()),
            )
            for feature in Feature
        ),
    )


def _made(name: str) -> ReferenceEngine:
    """Return an engine, be it here or not: what it says of itself is the same everywhere."""
    make: Any = engine_class(name)
    made: ReferenceEngine = make()
    return made


def shapes() -> str:
    """Return what each engine makes of pockets, polygons and posts."""
    rows = []
    for name in engine_names():
        known = _made(name).capabilities[Feature.POCKETS]
        said = {"exact": "exact", "approximate": "nearly", "none": "refuses them"}
        rows.append((f"`{name}`", said[known.support], known.how))
    return _table(("engine", "plays them", "how"), rows)


def laws() -> str:
    """Return the laws of impacts: what each uses, and where it comes from."""
    return _table(
        ("law", "of", "what it is", "it uses"),
        (
            (f"`{law.name}`", what, law.source, ", ".join(f"`{name}`" for name in law.uses))
            for what, laws in (("two balls", BALL_LAWS), ("a cushion", CUSHION_LAWS))
            for law in laws
        ),
    )


def rebounds() -> str:
    """Return the measured rebounds, and what the preset `carom` makes of them."""
    carom = Physics(preset="carom")
    fixed = carom.model_copy(update={"cushion_restitution": 0.87, "cushion_restitution_loss": 0.0})
    columns = [
        measured_rebounds(_PLAY, physics, degrees)
        for physics, degrees in ((carom, 5.0), (carom, 45.0), (fixed, 5.0))
    ]
    rows = []
    for bins in zip(*columns, strict=True):
        row = bins[0].row
        ratios = (f"{one.ratio:.3f} ({one.errors_off:+.1f})" for one in bins)
        rows.append(
            (f"{row.low:g} to {row.high:g} m/s", f"{row.value:.3f} ± {row.error:.3f}", *ratios)
        )
    heads = ("speed", "measured", "`carom`, 5°", "`carom`, 45°", "one restitution, 0.87, 5°")
    return _table(heads, rows)


def pool_rolling() -> str:
    """Return how cloth slowed cue balls of matches, and what the preset `pool` makes of it."""
    facts = facts_of("rolling-pool")
    pool = Physics(preset="pool")
    nearest = best_cloth("rolling-pool", make_engine("ghostball").capabilities)
    rows = []
    for row in facts.rows:
        found = [
            deceleration(_PLAY, pool.model_copy(update=cloth), row.place) for cloth in ({}, nearest)
        ]
        rows.append(
            (f"{row.low:g} to {row.high:g} m/s", _plus_minus(row, 3), *_errors_off(row, found, 3))
        )
    numbers = ", ".join(f"`{name}` {value:.4f}" for name, value in nearest.items())
    return _table(("speed", "measured [m/s²]", "`pool`", f"`pool` with {numbers}"), rows)


def snooker_rebounds() -> str:
    """Return square rebounds of snooker: measured, of the preset, and of the best of other laws."""
    measured = facts_of("cushion-snooker").rows
    engines = ("ghostball", "pybullet")  # one whose restitution falls, and one where it can't
    best = [
        best_cushion("cushion-snooker", name, make_engine(name).capabilities) or {}
        for name in engines
    ]
    presets = [Physics(preset="snooker", **changes) for changes in ({}, *best)]
    columns = [[square_rebound(_PLAY, one, row.place) for row in measured] for one in presets]
    rows = [
        (
            f"{row.at:g} m/s",
            f"{row.value:.3f} m/s",
            *(f"{one.speed_after:.3f} ({one.speed_after - row.value:+.3f})" for one in contacts),
        )
        for row, *contacts in zip(measured, *columns, strict=True)
    ]
    after = np.array([[one.speed_after for one in contacts] for contacts in columns])
    off = np.sqrt(np.mean((after - [row.value for row in measured]) ** 2, axis=1))
    rows.append(("typical difference", "", *(f"{x:.3f}" for x in off)))
    falls, fixed = (
        ", ".join(f"{symbol} = {one[name]:g}" for name, symbol in _SYMBOLS.items() if one[name])
        for one in best
    )
    heads = ("speed before", "measured, after", "`snooker`")
    return _table((*heads, f"`frictional`, {falls}", f"`frictional`, {fixed}"), rows)


def hits() -> str:
    """Return what the preset `snooker` makes of five oblique hits."""
    rows = []
    for row in facts_of("hits-snooker").rows:
        speed, cut = row.given["speed"], row.place
        hit = oblique_hit(_PLAY, Physics(preset="snooker"), speed, cut)
        pairs = (
            (row.value, hit.cue_speed, 3),
            (row.also["object_speed"], hit.object_speed, 3),
            (row.also["cue_angle"], hit.cue_angle, 1),
        )
        cells = (f"{measured:.{n}f}, {played:.{n}f}" for measured, played, n in pairs)
        rows.append((f"{speed:.3f} m/s, {cut:.1f}°", *cells))
    heads = ("speed, cut", "cue ball [m/s]", "object ball [m/s]", "cue ball's way [°]")
    return _table(heads, rows)


def banks() -> str:
    """Return slid banks: five tables, the preset `pool`, and what speed makes of it."""
    best = best_cushion("banks-pool", "ghostball", make_engine("ghostball").capabilities) or {}
    rows = facts_of("banks-pool").rows
    through = partial(through_points, _PLAY, aims=[row.place for row in rows])
    pool = Physics(preset="pool")
    columns = [through(pool), through(pool, speed=3.0), through(pool, speed=7.0)]
    columns.append(through(Physics(preset="pool", **best)))
    cells = [
        (
            f"{row.at:g}",
            ", ".join(f"{value:.2f}" for value in row.of_each),
            _plus_minus(row, 2),
            *_errors_off(row, found, 2),
        )
        for row, *found in zip(rows, *columns, strict=True)
    ]
    name = f"{best['cushion']}`, e = {best['cushion_restitution']:g}"
    speeds = ("`pool`", "`pool`, 3 m/s", "`pool`, 7 m/s", f"`{name}")
    return _table(("aimed at", "aimed from, five tables", "mean ± spread", *speeds), cells)


def throws() -> str:
    """Return throw: measured, of the preset `pool`, and where a contact sticks."""
    rows = []
    for row in facts_of("throw-pool").rows:
        for cut, value in ((30.0, row.value), (45.0, row.also["at_45_degrees"])):
            played = throw_angle(_PLAY, Physics(preset="pool"), row.place, cut)
            sticks = math.degrees(math.atan(math.tan(math.radians(cut)) / 7.0))
            cells = (f"{one:.1f}°" for one in (value, played, sticks))
            rows.append((f"{row.place:g} m/s, {cut:g}°", *cells))
    return _table(("speed, cut", "measured", "`pool`", "no friction throws farther"), rows)


def _plus_minus(row: Row, digits: int) -> str:
    return f"{row.value:.{digits}f} ± {row.uncertainty:.{digits}f}"


def _errors_off(row: Row, found: Iterable[float], digits: int) -> Iterable[str]:
    """Return each figure with how many standard errors it is above the measurement."""
    error = row.uncertainty
    assert error is not None
    return (f"{one:.{digits}f} ({(one - row.value) / error:+.1f})" for one in found)


def nearest() -> str:
    """Return how near each engine comes to the measured rebounds, from the committed search."""
    stored = committed(ReboundsMeasurement)
    rows = (one.row for one in (stored.best if stored else ()))
    return _table(("engine", "law of cushions", "best coefficients", "typical", "most"), rows)


def fitted_example(path: str) -> str:
    """Return what was fitted to the example's tracks beside what they were made with."""
    text = Path(path).read_text(encoding="utf-8")
    errors = dict(re.findall(r"^(\w+) = .* # \+- (\S+)$", text, re.MULTILINE))
    rows = []
    for name, value in tomllib.loads(text)["physics"].items():
        if name in errors:
            true, error = getattr(EXAMPLE_PHYSICS, name), float(errors[name])
            off = f"{(value - true) / error:+.1f}"
            rows.append((f"`{name}`", f"{true:g}", f"{value:g} ± {errors[name]}", off))
    return _table(("field", "true", "found", "standard errors off"), rows)


def fits() -> str:
    """Return how often the errors of fits hold, from the committed measurement."""
    stored = committed(FitsMeasurement)
    if stored is None:
        return "Not measured yet: `python -m benchmarks fits --store` does so."
    heads = ("field", "tables", "within 1.96 standard errors", "most")
    return "\n".join(
        [_table(heads, ((f"`{name}`", *cells) for name, *cells in stored.rows)), "", stored.sought]
    )


def made() -> str:
    """Return how often breaks make a ball, from the committed measurement."""
    stored = committed(MadeMeasurement)
    if stored is None:
        return "Not measured yet: `python -m benchmarks made --store` does so."
    return _table(("a break", f"of {stored.breaks} here", "published"), stored.rows)


def command_line() -> str:
    """Return the help of every command, from the parsers that read their options."""
    typer = [sys.executable, "-m", "typer", "ghostball.cli", "utils", "docs", "--name", "ghostball"]
    text = subprocess.run(typer, capture_output=True, text=True, check=True).stdout
    return text.partition("\n")[2]


def names(section: str) -> str:
    """Return what is public in a section of the page of Python, with the first line of its help."""
    page = Path("docs/api.md").read_text(encoding="utf-8")
    (part,) = re.findall(rf"^## {section}\n(.*?)(?=^## |\Z)", page, re.M | re.S)
    rows = []
    for where in re.findall(r"^::: (\S+)", part, re.M):
        module, _, name = where.rpartition(".")
        said = inspect.getdoc(getattr(import_module(module), name)) or ""
        rows.append((f"`{name}`", said.partition("\n")[0]))
    return _table(("name", "what it is"), rows)


def board_table(board: Board, *, reported: bool) -> str:
    """Return a board as a table in Markdown, with what its signs say and its columns ask."""
    columns = columns_of(board, reported=reported)
    from docs.engine_pages import cell_link  # noqa: PLC0415 - which tabulates by this module

    rows = (
        (
            f"[`{row}`](engines/{row.partition(':')[0]}.md)",
            *(cell_link(board, row, one) for one in columns),
        )
        for row in board.rows
    )
    lines = [_table(("engine", *(column.title for column in columns)), rows)]
    signs = [f"{one.sign} {one.says}" for one in looks_of(board, columns) if one.sign]
    said = f"{'; '.join(signs)}. Lengths are how far off a run ends."
    lines += ["", f"{said} Measured on {about(board, columns)}.", ""]
    if not reported:
        lines += (f"- **{one.title}**{unit_of(one)}: {one.question}." for one in columns)
    return "\n".join(lines)


def board() -> str:
    """Return the committed board of engines."""
    stored = committed_board()
    if stored is None:
        return "No board was measured yet: `ghostball leaderboard` does so."
    return board_table(stored, reported=False)


USES = (
    ("rules, an AI that tries many shots, a test's truth", "ghostball"),
    ("a game in the plane that may move its balls itself", "pymunk:contact_steps=exact,dt=0.02"),
    ("a game in the plane, in steps of 1 ms", "pymunk:dt=0.001"),
    ("the same as one types it: 60 steps/s", "pymunk:config=default,dt=0.016666666666666666"),
    ("a game in space that may move its balls itself", "pybullet:contact_steps=exact,dt=0.02"),
    ("a game in space, in steps of 1 ms", "pybullet:dt=0.001"),
    ("the same as one types it: 240 steps/s", "pybullet:config=default,dt=0.004166666666666667"),
)
"""What an engine is wanted for, and the label that was measured for it."""

ASKED = ("cut", "exact-steps", "break", "slide")
"""The columns of the board that decide for billiards."""


def choice() -> str:
    """Return which engine with which settings is how right, and what it costs."""
    measured = committed(PrecisionMeasurement)
    if measured is None:
        return "Nothing was measured yet: `ghostball precision --out DIR` does so."
    rows = []
    for use, label in USES:
        points = [one for one in measured.points if one.label == label]
        errors = [one.error for one in points]
        rows.append(
            (
                use,
                f"`{_shortened(label)}`",
                f"{format_length(median(errors))} ({format_length(max(errors))})",
                format_time(median(one.seconds for one in points)),
            )
        )
    heads = ("for", "engine and settings", "error: median (largest)", "time of a shot")
    scenes = ", ".join(f"`{name}`" for name in sorted({one.scene for one in measured.points}))
    place = f"{measured.environment['cpu']}, {str(measured.environment['date'])[:10]}"
    return f"{_table(heads, rows)}\n\nOver those of {scenes} that each can play; {place}."


def _shortened(label: str) -> str:
    """Return a label with its step as one writes it."""
    return label.replace("0.016666666666666666", "1/60").replace("0.004166666666666667", "1/240")


def other_engines() -> str:
    """Return what the board says of engines that the ladder of steps has not."""
    stored = committed_board()
    if stored is None:
        return "No board was measured yet: `ghostball leaderboard` does so."
    columns = [one for one in columns_of(stored, reported=False) if one.id in ASKED]
    left_out = {label.partition(":")[0] for _, label in USES}
    left_out |= {name for name, package in PACKAGE_OF.items() if package == "ghostball"}
    chosen = [row for row in stored.rows if ":" not in row and row not in left_out]
    rows = ((f"`{row}`", *(cell_text(stored, row, one) for one in columns)) for row in chosen)
    return _table(("engine", *(one.title for one in columns)), rows)


def reported() -> str:
    """Return what was reported of engines: each thread, its cause, its cure, and the verdicts."""
    parts = []
    for one in FAULTS.values():
        assert one.thread is not None
        where = "/".join(one.thread.split("/")[3:5])
        thread = f"[{where} #{one.thread.rpartition('/')[2]}]({one.thread})"
        parts.append(
            f"- **{one.title}** ({thread}). {one.question}. *Cause:* {one.cause} *Cure:* {one.cure}"
        )
    stored = committed_board()
    if stored is not None and columns_of(stored, reported=True):
        parts += ["", board_table(stored, reported=True)]
    return "\n".join(parts)
