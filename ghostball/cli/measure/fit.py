"""`ghostball fit`: fit an engine's physics to tracks of a real table, and print the result."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import typer
from rich.console import Group, RenderableType

from ghostball.cli.measure.commands import FitOptions
from ghostball.cli.options import OriginChoice, TextOrJson
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.single_shots import (
    check_plot,
    check_writable,
    compile_first,
    engine_process,
)
from ghostball.cli.shared.tables import facts_table, table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.model import GhostballError, Physics
from ghostball.model.impact_laws import CUSHION_LAWS
from ghostball.model.text_files import write_whole
from ghostball.reference_adapters import make_engine
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.measured.tracks import HEADER, Surface, read_tracks

try:
    from ghostball.reports.figures.fitted import draw_fit
    from ghostball.validation.measured.fit.clean_events import find_clean_events
    from ghostball.validation.measured.fit.fields import FIELDS
    from ghostball.validation.measured.fit.fit import NotEnoughError, fit_table
    from ghostball.validation.measured.fit.fit_result import Fit
except ImportError as error:
    missing = (error.name or "").partition(".")[0]
    if missing not in {"scipy", "threadpoolctl"}:
        raise
    raise GhostballError(
        f"a fit needs {missing}, which isn't installed here: run pip install '.[fit]' in a clone "
        "of Ghostball"
    ) from None

LARGEST_TABLE = 20.0
"""Upper limit of the table's length and width [m]; a larger number isn't in metres."""
_UNDETERMINED = "not determined by these tracks"


def run(asked: FitOptions) -> ExitStatus:
    """Fit the physics, print and write the result, and return the exit status.

    Raises `typer.BadParameter` if an option is invalid, `NotEnoughError` if there are too few
    events.
    """
    tracks, preset, law, nose_height = asked.tracks, asked.preset, asked.law, asked.nose_height
    surface = _surface(asked.table, asked.radius)
    chosen = _fitted_fields(asked.fields)
    presets = [name for name in Physics.PRESETS if Physics(preset=name).motion == "sliding"]
    if preset not in presets:
        raise typer.BadParameter(
            f"must be one of {', '.join(presets)}, in which balls slide; got {preset!r}",
            param_hint="--preset",
        )
    laws = [one.name for one in CUSHION_LAWS if one.uses and one.fitted]
    if law is not None and law not in laws:
        raise typer.BadParameter(
            f"must be one of {', '.join(laws)}, got {law!r}", param_hint="--law"
        )
    if nose_height is not None:
        low, high = asked.radius, 2.0 * asked.radius
        if not low <= nose_height < high:
            raise typer.BadParameter(
                f"must be from a ball's radius, {low:g}, to below a ball's height, {high:g}, got "
                f"{nose_height:g}. Give metres",
                param_hint="--nose-height",
            )
        if "cushion_height" in chosen:
            raise typer.BadParameter(
                "gives the height that --fields asks to fit. Remove one of the two",
                param_hint="--nose-height",
            )
    check_plot(asked.plot)
    if asked.out is not None:
        check_writable(asked.out, "--out")
    made = make_engine(asked.engine)
    columns = None if asked.columns is None else _columns(asked.columns)
    centred = asked.origin is OriginChoice.CENTRE
    found = find_clean_events(read_tracks(tracks, surface, columns, centred=centred), surface)
    compile_first([], asked.engine)
    with (
        counting(f"fitting {made.name}") as count,
        engine_process(made, asked.time_limit) as playing,
    ):
        try:
            fitted = fit_table(
                found,
                made,
                partial(playing.simulate, record="trajectory"),
                preset=preset,
                law=law,
                fields=chosen,
                nose_height=nose_height,
                progress=count,
            )
        except NotEnoughError as error:
            raise NotEnoughError(f"{tracks}: {error}") from None
    text = physics_toml(fitted, preset)
    if asked.out is not None:
        write_whole(asked.out, text)
    if asked.plot is not None:
        draw_fit(fitted, asked.plot)
    if asked.form is TextOrJson.JSON:
        typer.echo(json.dumps(_json_values(fitted, made.name, preset)))
    else:
        stdout().print(Group(*_parts(fitted)))
        if asked.out is None:
            typer.echo(text, nl=False)
        for said, path in (("written to", asked.out), ("drawn in", asked.plot)):
            if path is not None:
                stdout().print(f"{said} {path}", soft_wrap=True, markup=False)
    return ExitStatus.PASSED


def _columns(text: str) -> dict[str, str]:
    """Return the names of columns in a text such as "t=time,x=pos_x"."""
    columns: dict[str, str] = {}
    for pair in text.split(","):
        name, equals, column = (part.strip() for part in pair.partition("="))
        if name not in HEADER or not equals or not column or name in columns:
            raise typer.BadParameter(
                f"must give a column for some of {', '.join(HEADER)}, each once, such as t=time, "
                f"got {pair!r:.100}",
                param_hint="--columns",
            )
        columns[name] = column
    return columns


def _surface(table: tuple[float, float], radius: float) -> Surface:
    """Return the playing surface; raises `typer.BadParameter` if its sizes can't be metres."""
    for name, value in (("LENGTH", table[0]), ("WIDTH", table[1])):
        if not 0.0 < value <= LARGEST_TABLE:
            raise typer.BadParameter(
                f"{name} must be above 0 and at most {LARGEST_TABLE:g} m, got {value:g}. Give "
                "metres",
                param_hint="--table",
            )
    if not (math.isfinite(radius) and 0.0 < radius < min(table) / 4.0):
        raise typer.BadParameter(
            f"must be above 0 and well below the width of the table, got {radius:g}. Give metres",
            param_hint="--radius",
        )
    return Surface(table[0], table[1], radius)


def _fitted_fields(fields: str | None) -> Sequence[str]:
    """Return the names in `--fields`, or () without the option.

    Raises `typer.BadParameter` if a name isn't a field that can be fitted.
    """
    if fields is None:
        return ()
    names = tuple(dict.fromkeys(name.strip() for name in fields.split(",")))
    for name in names:
        if name not in FIELDS:
            raise typer.BadParameter(
                f"can't fit {name!r}. Choose from {', '.join(FIELDS)}", param_hint="--fields"
            )
    return names


def rounded(value: float, error: float) -> str:
    """Return a value as text, with decimals down to the second digit of its error.

    >>> rounded(0.0100123, 0.000021), rounded(0.9376, 0.0034), rounded(0.2, 0.0)
    ('0.010012', '0.9376', '0.2')
    """
    if not error > 0.0 or not math.isfinite(error):
        return f"{value:.4g}"
    return f"{value:.{max(1 - math.floor(math.log10(error)), 0)}f}"


def physics_toml(fitted: Fit, preset: str) -> str:
    """Return the `[physics]` table of a scene as TOML, with the standard errors in comments."""
    lines = ["[physics]", f'preset = "{preset}"']
    given = Physics(preset=preset)
    for name in type(given).model_fields:
        value, error = getattr(fitted.physics, name), fitted.errors.get(name)
        if error is not None:
            sure = f"+- {error:.2g}" if math.isfinite(error) else _UNDETERMINED
            lines.append(f"{name} = {rounded(value, error)}  # {sure}")
        elif name in fitted.assumed:
            known = fitted.assumed[name]
            assumed = f"assumed {known.mean:.4g} +- {known.spread:.2g}"
            lines.append(f"{name} = {rounded(value, known.spread)}  # {assumed}")
        elif value != getattr(given, name):
            lines.append(f"{name} = {json.dumps(value)}")
    return "\n".join(lines) + "\n"


def _parts(fitted: Fit) -> Iterator[RenderableType]:
    """Yield the printed parts: the table of values, then facts about events and errors."""
    rows = []
    for name, error in fitted.errors.items():
        value = getattr(fitted.physics, name)
        note = "at the limit of its allowed range" if name in fitted.ends else ""
        if not math.isfinite(error):
            note = _UNDETERMINED
        rows.append((name, rounded(value, error), f"{error:.2g}", note))
    yield table_of(
        ("field", "value", "standard error", ""), rows, right=("value", "standard error")
    )
    counts = ", ".join(f"{count} {name}" for name, count in fitted.counts.items())
    facts = {
        "events": f"{counts}; tracker noise: {1e3 * fitted.noise:.2g} mm",
        "goodness": f"{fitted.goodness:.2f}; 1 if only noise is left",
    }
    if fitted.laws:
        tried = ", ".join(f"{name} {value:.2f}" for name, value in fitted.laws.items())
        facts["cushion"] = f"{fitted.physics.cushion}; goodness of contacts: {tried}"
    if len(fitted.laws_alike) > 1:
        facts["not distinguishable"] = f"the laws {', '.join(fitted.laws_alike)}"
    for one, other in fitted.not_told_apart:
        facts[f"not separable: {one}"] = f"{other}: a change in one compensates for the other"
    for name, known in fitted.assumed.items():
        facts[f"assumed: {name}"] = (
            f"{known.mean:.4g} +- {known.spread:.2g} between tables; the errors allow for it"
        )
    for name in fitted.unsettled:
        facts[f"not converged: {name}"] = (
            "the search did not reach the best values; give more shots"
        )
    for name, why in fitted.not_told.items():
        facts[f"too few data for {name}"] = why
    yield facts_table(facts)


def _json_values(fitted: Fit, engine: str, preset: str) -> dict[str, Any]:
    """Return a fit as values for JSON; `error` is the standard error, None if undetermined."""
    return {
        "physics": {
            name: {
                "value": getattr(fitted.physics, name),
                "error": error if math.isfinite(error) else None,
            }
            for name, error in fitted.errors.items()
        },
        "law": fitted.physics.cushion,
        "laws": fitted.laws,
        "laws_not_told_apart": fitted.laws_alike,
        "events": fitted.counts,
        "goodness": fitted.goodness,
        "unsettled": fitted.unsettled,
        "not_told_apart": [list(pair) for pair in fitted.not_told_apart],
        "not_told": fitted.not_told,
        "assumed": {
            name: {"value": known.mean, "spread": known.spread}
            for name, known in fitted.assumed.items()
        },
        "at_an_end": fitted.ends,
        "noise": fitted.noise,
        "engine": engine,
        "preset": preset,
    }
