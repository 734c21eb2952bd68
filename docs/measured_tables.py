"""Tables of the documentation that show committed measurements; each function returns Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from statistics import median
from typing import Any
from unittest.mock import patch

import numpy as np
import pymunk

from benchmarks.board import HEADS, BoardCase, BoardMeasurement
from benchmarks.fits import FitsMeasurement
from benchmarks.made_balls import FLIGHTS, GAPS, MadeBallsMeasurement, percent
from benchmarks.measurements import measured
from benchmarks.rebounds import ReboundsMeasurement
from docs.recipes import pymunk_recipe
from docs.tables import table
from ghostball import find_scene, simulate
from ghostball.model.arrays import FloatArray
from ghostball.model.features import Feature
from ghostball.reference_adapters import engine_class
from ghostball.reports.accuracy import median_error, median_text
from ghostball.reports.precision import is_finest
from ghostball.reports.style import format_length, format_time
from ghostball.validation.checks.accuracy import kind_of
from ghostball.validation.grading.tolerances import EPS, ROUNDINGS
from ghostball.validation.measured.breaks import inputs, setups
from ghostball.validation.measured.facts import binomial_error
from ghostball.validation.parallel.sources import PACKAGE_OF
from ghostball.validation.precision.points import (
    PrecisionMeasurement,
    PrecisionPoint,
    knee_of,
    order_of,
)
from ghostball.validation.results.records import AccuracyKind
from ghostball.validation.scenes.library import BOARD, select
from ghostball.validation.truth.scene_truth import truth_of

USES = (
    ("game rules, an AI that tries many shots, reference results", "ghostball"),
    ("2D game; your code moves the balls between contacts", "pymunk:contact_steps=exact,dt=0.02"),
    ("2D game, time steps of 1 ms", "pymunk:dt=0.001"),
    ("2D game, with the settings of a beginner", "pymunk:config=naive,dt=0.016666666666666666"),
    ("3D game; your code moves the balls between contacts", "pybullet:contact_steps=exact,dt=0.02"),
    ("3D game, time steps of 1 ms", "pybullet:dt=0.001"),
    ("3D game, with the settings of a beginner", "pybullet:config=naive,dt=0.004166666666666667"),
)
"""Each use of an engine, and the label that was measured for this use."""

STEP_SHOWN = 1e-3
"""The tables of steps show the error of the measured step nearest to this one [s]."""

ASKED = ("half-ball-1", "slide-to-rest", "throw")
"""The scenes of the board that matter most for billiards."""


OWN = ":cloth=own"
"""Settings of an engine with its own cloth, in a label."""


def board() -> str:
    """Return a table of the engines that the last run measured: scenes by class, error and time."""
    stored = measured(BoardMeasurement)
    rows = ((", ".join(map(_linked, labels)), *cells) for labels, cells in stored.rows())
    said = [
        f"{len(select([BOARD]))} scenes, measured on {stored.where}:",
        f'<div class="sortable" markdown="1">\n\n{table(HEADS, rows)}\n\n</div>',
    ]
    if earlier := dict.fromkeys(_linked(one) for one in stored.earlier if ":" not in one):
        said.append(
            "Earlier runs measured more engines, with time steps of 1 ms. Their pages show the "
            f"results: {', '.join(earlier)}. For `half-ball-1`, they show the largest error of "
            "eight runs."
        )
    return "\n\n".join(said)


def own_cloths() -> str:
    """Return the rest errors with the cloth of the adapter and of the engine, by scene."""
    stored = measured(BoardMeasurement)
    own = {label.partition(":")[0]: stored.of(label) for label in stored.labels if OWN in label}
    scenes = [
        one.name
        for one in select([BOARD])
        if np.any(one.rolling_frictions)
        and (one.table is None or not one.table.holes)
        and any(cases[one.name].kind for cases in own.values() if one.name in cases)
    ]
    rows = []
    for name, cases in own.items():
        pairs = ((_error_in(stored.of(name).get(one)), _error_in(cases.get(one))) for one in scenes)
        errors = (" → ".join(dict.fromkeys(pair)) for pair in pairs)
        rows.append((_linked(name), *errors, _own_cloth_of(name)))
    heads = ("engine", *(f"`{one}`" for one in scenes), "the engine's own cloth")
    return table(heads, rows)


def _error_in(case: BoardCase | None) -> str:
    if case is None or case.kind is None:
        return "–"
    return case.model_copy(update={"seconds": None}).text


def _own_cloth_of(engine: str) -> str:
    """Return how an engine supports sliding, or else rolling, on its own cloth."""
    known: Any = engine_class(engine)
    able = known.CAPABILITIES["own-cloth"]
    one = able[Feature.SLIDING]
    how: str = one.how if one.support != "none" else able[Feature.ROLLING].how
    return how


def _linked(label: str) -> str:
    return f"[`{label}`](engines/{label.partition(':')[0]}.md)"


def other_engines() -> str:
    """Return results of the board for engines that the precision measurement lacks."""
    stored = measured(BoardMeasurement)
    left_out = {label.partition(":")[0] for _, label in USES}
    left_out |= {name for name, package in PACKAGE_OF.items() if package == "ghostball"}
    rows = []
    for engine in (one for one in stored.labels if ":" not in one and one not in left_out):
        found, exact = stored.of(engine), stored.of(f"{engine}:contact_steps=exact")
        cells = [found.get(ASKED[0]), exact.get(ASKED[0]), *map(found.get, ASKED[1:])]
        rows.append((f"`{engine}`", *("–" if one is None else one.text for one in cells)))
    cut, *others = (f"`{name}`" for name in ASKED)
    return table(("engine", cut, f"{cut}, exact steps", *others), rows)


def choice() -> str:
    """Return the rest error and run time of each engine and its settings, by use."""
    stored = measured(PrecisionMeasurement)
    rows = []
    for use, label in USES:
        points = [one for one in stored.points if one.label == label]
        errors = sorted((one.error, _class_of(one)) for one in points)
        middle, is_middle_exact = median_error(errors)
        most, most_class = errors[-1]
        middle_text = median_text(middle, is_exact=is_middle_exact)
        most_text = median_text(most, is_exact=most_class == "exact")
        rows.append(
            (
                use,
                f"`{_shortened(label)}`",
                middle_text if middle_text == most_text else f"{middle_text} ({most_text})",
                format_time(median(one.call_seconds for one in points)),
            )
        )
    heads = ("use", "engine and settings", "rest error: median (largest)", "time for a shot")
    scenes = ", ".join(f"`{name}`" for name in sorted({one.scene for one in stored.points}))
    said = f"Scenes, if the engine supports them: {scenes}. Measured on {stored.where}."
    return f"{table(heads, rows)}\n\n{said}"


def _class_of(point: PrecisionPoint) -> AccuracyKind:
    """Return the accuracy class of the error of a point in a scene with a closed form."""
    conditioning = _conditioning(point.scene)
    rounding = ROUNDINGS * EPS * float(np.max(conditioning))
    return "exact" if point.error <= rounding else kind_of(point.error)


@cache
def _conditioning(scene: str) -> FloatArray:
    """Return `Truth.conditioning` of a shipped scene."""
    found = truth_of(find_scene(scene), parts={"rest", "conditioning"}).conditioning
    assert found is not None  # each measured scene has a closed form
    return found


def _shortened(label: str) -> str:
    """Return a label with its time step as people write it."""
    return label.replace("0.016666666666666666", "1/60").replace("0.004166666666666667", "1/240")


def pymunk_recipe_reaches() -> str:
    """Return the rest error and number of steps of pymunk's recipe, with fixed and exact steps."""
    true = simulate(find_scene("half-ball-cut")).rest_positions[:, :2]
    found, take_step = [], pymunk.Space.step
    for exact in (False, True):
        with (
            patch.object(pymunk.Space, "step", autospec=True, side_effect=take_step) as step,
            patch.object(pymunk_recipe, "advance", side_effect=pymunk_recipe.advance) as frame,
        ):
            balls = pymunk_recipe.play(exact)
        places = np.array([tuple(ball.position) for ball in balls])
        off = float(np.max(np.linalg.norm(places - true, axis=1)))
        found.append((format_length(off), step.call_count, frame.call_count))
    (own, own_steps, _), (exact_off, exact_steps, frames) = found
    return (
        f"The program takes {own_steps} time steps of 1 ms, and the rest position error of the cut "
        f"is {own}. With time steps that end at contacts, the error is {exact_off}, and the "
        f"program calls `space.step` {exact_steps} times in {frames} frames of 1/60 s."
    )


def steps() -> str:
    """Return a table for each scene; an error is the largest of all phases of the time step."""
    stored = measured(PrecisionMeasurement)
    parts = [f"Measured on {stored.where}. The speed of the machine changes no error."]
    heads = (
        "engine",
        "order",
        "error at the longest step",
        "error near 1 ms",
        "run time near 1 ms",
        "of which in the engine's own steps",
        "error at the shortest step",
        "recommended step",
    )
    points = [one for one in stored.points if one.step is not None]
    for scene, title in dict.fromkeys((one.scene, one.title) for one in points):
        mine = [one for one in points if one.scene == scene]
        engines = dict.fromkeys(one.engine for one in mine)
        rows = (_steps_of([one for one in mine if one.engine == engine]) for engine in engines)
        parts += [f"## {scene}", f"{title}.", table(heads, rows)]
    return "\n\n".join(parts)


def _steps_of(points: Sequence[PrecisionPoint]) -> tuple[str, ...]:
    """Return a row of the table for the points of one engine on one scene, longest step first."""
    near = min(points, key=lambda one: abs(math.log((one.step or math.inf) / STEP_SHOWN)))
    # A number and its unit stay on one line.
    longest, middle, shortest = (
        f"{_error(one)} at {format_time(one.step)}".replace(" ", "\N{NO-BREAK SPACE}")
        for one in (points[0], near, points[-1])
    )
    knee, order = knee_of(points), order_of(points)
    step = "none"
    if knee is not None:
        step = format_time(knee.step) + (" or shorter" if is_finest(knee, points) else "")
    return (
        f"`{points[0].engine}`",
        "–" if order is None else f"{round(order, 1) + 0.0:.1f}",
        longest,
        middle,
        format_time(near.call_seconds),
        format_time(near.engine_seconds),
        shortest,
        step,
    )


def _error(point: PrecisionPoint) -> str:
    return format_length(point.error_high) if point.same_events else "wrong collisions"


def rebounds(engine: str = "") -> str:
    """Return the difference of each engine, or of a named one, from the measured rebounds."""
    best = measured(ReboundsMeasurement).best
    rows = [one.row for one in best if engine in ("", one.engine)]
    heads = ("engine", "cushion law", "best coefficients", "rms", "largest")
    return table(heads, rows) if rows else ""


def made_balls() -> str:
    """Return the shares of breaks with each outcome: published, and of each way of impacts."""
    heads = ("break", "outcome", "measured", "impacts that last", "one after another")
    rows = []
    for one in measured(MadeBallsMeasurement).compared():
        lasting = f"{percent(one.share, one.error)}, inputs ± {100.0 * one.unknown:.1f} %"
        texts = (percent(*one.published), f"{lasting} ({one.errors_off:+.1f})", percent(*one.rigid))
        rows.append((one.setup, one.outcome, *texts))
    return table(heads, rows)


def break_inputs() -> str:
    """Return the values of the model of a break, with their sources and effects."""
    stored, first = measured(MadeBallsMeasurement), setups()[0].name
    effects = [stored.effects(first, outcome) for outcome in ("made", "scratch")]
    rows = []
    for one in inputs():
        value = f"{one.value:.4g} ± {one.error:.2g} {one.unit if one.unit != '1' else ''}"
        moves = (f"{100.0 * found[one.name][0]:+.1f} %" for found in effects)
        rows.append((one.meaning, value.strip(), *moves, one.source))
    heads = ("value", "with its uncertainty", "made", "scratch", "source")
    return table(heads, rows)


def uneven_racks() -> str:
    """Return how often a break makes a ball, by the gaps of the rack."""
    stored, first = measured(MadeBallsMeasurement), setups()[0].name
    rows = []
    for gap in GAPS:
        shares = (
            percent(*stored.cell(first, way, {"gap": gap, "unevenness": unevenness}).share("made"))
            for way in ("compliant", "sequential")
            for unevenness in (1.0, 0.0)
        )
        rows.append((f"{1e3 * gap:g} mm", *shares))
    frozen = stored.cell(first, "simultaneous", {"gap": 0.0}).share("made")
    lasting, rigid = "impacts that last", "one after another"
    heads = ("mean gap", f"{lasting}, uneven", f"{lasting}, even", f"{rigid}, uneven", rigid)
    return (
        f"{table((*heads[:4], f'{heads[4]}, even'), rows)}\n\n"
        "With impacts at one instant, racks with gaps have the same results as with impacts one "
        "after another, because no two impacts happen at once. If all balls touch, "
        f"{percent(*frozen)} of the breaks make a ball."
    )


def flying_breaks() -> str:
    """Return what changes if balls may fly once the rack has opened."""
    stored, first = measured(MadeBallsMeasurement), setups()[0].name
    rows = []
    for name, changed in zip(
        ("stay on the cloth", "may fly", "may fly, without bounces"),
        FLIGHTS,
        strict=True,
    ):
        one = stored.cell(first, "compliant", changed)
        left = percent(one.left / one.breaks, binomial_error(one.left, one.breaks))
        rows.append((name, percent(*one.share("made")), percent(*one.share("scratch")), left))
    heads = ("balls", "makes a ball", "scratches", "a ball leaves the table over a cushion")
    return table(heads, rows)


def fits() -> str:
    """Return how often the true value lies within the stated errors of a fit."""
    stored = measured(FitsMeasurement)
    heads = ("field", "tables", "within 1.96 standard errors", "largest")
    rows = ((f"`{name}`", *cells) for name, *cells in stored.rows)
    return f"{table(heads, rows)}\n\n{stored.extent} {stored.law_searches}"
