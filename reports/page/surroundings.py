"""What lies around a run: its environment, and what the stress suite found beside it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup

from ghostball.reports.markdown import UNAVAILABLE, engine_settings, flat_values
from ghostball.reports.page.rendering import render
from ghostball.reports.stress_report import about_text, survival_table, worst_cases
from ghostball.validation.results.store import Results
from ghostball.validation.stress import StressFolder
from ghostball.validation.stress.findings import is_stress_folder

STRESS_FOLDERS = ("stress", "stress-quick", "stress-full")
"""Where in a results folder a stress run may lie."""

_GROUPS: dict[str, tuple[str, ...]] = {
    "Machine": ("cpu", "cores", "os", "python"),
    "Versions": ("versions",),
    "Code and run": ("git", "date", "command", "run", "state"),
}
"""Which entries of the environment a table shows; all others but engines are in the last one."""


def environment_html(results: Results) -> Markup:
    """Return where and with what the run was made, as tables."""
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


def stress_html(results: Results) -> Markup:
    """Return what engines survived, where a stress run lies in the results folder."""
    runs = []
    for folder in stress_folders(results.path):
        # The headings of stress.md are not those of the page.
        worst = [part for part in worst_cases(folder) if not part.startswith("## ")]
        runs.append((folder.path.name, about_text(folder), survival_table(folder), worst))
    return render("stress.html", runs=runs)


def stress_folders(path: Path) -> list[StressFolder]:
    """Return the stress runs in a results folder.

    Raises
    ------
    ResultsError
        Where one of them is damaged, or of another schema version.
    """
    return [
        StressFolder.load(path / name) for name in STRESS_FOLDERS if is_stress_folder(path / name)
    ]


def _rows(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    rows: Iterable[tuple[str, str]] = flat_values(values)
    return list(rows)
