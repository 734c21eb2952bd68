"""Sections of the page about the run itself: references, environment, engine settings."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from ghostball.reports.page.rendering import render
from ghostball.reports.page.scene_numbers import counted_rows
from ghostball.validation.results.store import Results

UNAVAILABLE = "unavailable"
"""Text in place of the settings of an engine that could not run."""

_GROUPS: dict[str, tuple[str, ...]] = {
    "Machine": ("cpu", "cores", "os", "python"),
    "Versions": ("versions",),
    "Software and run": ("git", "date", "command", "run", "state"),
}
"""Entries of the environment in each table, by title. A last table has the remaining entries."""


def environment_html(results: Results) -> Markup:
    """Return tables of the machine, versions, options and engine settings of the run."""
    environment = {k: v for k, v in results.environment.items() if k != "engine_settings"}
    if isinstance(environment.get("command"), list):
        environment["command"] = shlex.join(map(str, environment["command"]))
    placed = {name for names in _GROUPS.values() for name in names}
    tables = [
        (title, _rows({k: environment[k] for k in names if k in environment}))
        for title, names in _GROUPS.items()
    ]
    asked = _rows({k: v for k, v in environment.items() if k not in placed})
    settings = [
        (label, None if values is None else sorted(values.items()))
        for label, values in engine_settings(results).items()
    ]
    return render(
        "environment.html",
        tables=[one for one in tables if one[1]],
        asked=asked,
        settings=settings,
        unavailable=UNAVAILABLE,
    )


def truth_html(results: Results) -> Markup:
    """Return the kinds of reference result, and the approximations that the runs counted."""
    return render("truth.html", counted=list(counted_rows(results)))


def engine_settings(results: Results) -> dict[str, dict[str, Any] | None]:
    """Return the settings of each engine as used, by its label; None where it is unavailable.

    The environment stores the requested settings, in which the time step may be missing because
    the engine chooses it. The settings of a finished case include the time step.
    """
    used = {case.label: case.settings for case in reversed(results.cases) if case.outcome == "ran"}
    asked: dict[str, dict[str, Any] | None] = results.environment.get("engine_settings", {})
    return {**asked, **used}


def _rows(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return one row for each value; a mapping gets one row for each of its entries."""
    rows: list[tuple[str, str]] = []
    for key, value in values.items():
        if isinstance(value, Mapping):
            rows += ((f"{key}.{inner}", _plain(entry)) for inner, entry in value.items())
        else:
            rows.append((key, _plain(value)))
    return rows


def _plain(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key}={_plain(entry)}" for key, entry in value.items())
    if isinstance(value, list):
        return ", ".join(map(_plain, value))
    return str(value)
