"""The program behind `action.yml`, Ghostball's GitHub action: `python -m ghostball.cli.action`.

It runs `ghostball regress` and writes the results for GitHub: annotations of the workflow run, a
step summary, a report page to upload, and outputs for later steps. The inputs are environment
variables (`INPUT_ENGINE`, ...); GitHub's own variables name the files for outputs and summary.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import typer

from ghostball.cli.gate import regress
from ghostball.cli.gate.commands import RegressOptions
from ghostball.cli.options import AUTO, FailOnChoice, FigureChoice, Format, processors
from ghostball.cli.shared import report
from ghostball.cli.shared.config import FILE, ConfigError, load_config
from ghostball.cli.shared.terminal import command
from ghostball.model import GhostballError
from ghostball.reports.ci.findings import note
from ghostball.reports.error_changes import growth
from ghostball.reports.outcome import CHANGES, failures
from ghostball.validation.baselines import Regression, load_regressions
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.store import Results

VERDICTS = {
    ExitStatus.PASSED: "passed",
    ExitStatus.CHECK_FAILED: "failed",
    ExitStatus.NOT_JUDGED: "not-judged",
}
"""Value of the output `verdict` for each exit status; "error" for all other statuses."""


def options_from(environment: Mapping[str, str]) -> RegressOptions:
    """Return the options of `regress` from environment variables.

    Raises `ConfigError` if an input is invalid, or if no engine is named.
    """
    texts = {
        name: environment.get(f"INPUT_{name.upper()}", "").strip()
        for name in ("engine", "scenes", "baselines", "fail_on")
    }
    known = [choice.value for choice in FailOnChoice]
    if texts["fail_on"] not in ("", *known):
        raise ConfigError(
            f"input `fail-on` must be one of {', '.join(known)}, got {texts['fail_on']!r}"
        )
    engines = texts["engine"].split()
    if not engines and not load_config().engines:
        raise ConfigError(
            "no engine is named. Name one in the workflow, such as `engine: my_engine:simulate`, "
            f"or in `engines` of `[tool.ghostball]` in {FILE}"
        )
    return RegressOptions(
        scenes=shlex.split(texts["scenes"]),
        engine=engines,
        baselines=Path(texts["baselines"]) if texts["baselines"] else None,
        fail_on=FailOnChoice(texts["fail_on"]) if texts["fail_on"] else None,
        jobs=processors(AUTO),
        form=Format.GITHUB,
    )


@command
def main() -> None:
    """Run `regress`, write annotations, outputs, summary and report, and exit with its status."""
    try:
        status, out = regress.run(options_from(os.environ)), load_config().out
    except GhostballError as error:
        print(note("error", "not run", str(error)), flush=True)
        _append("GITHUB_STEP_SUMMARY", f"## ✗ Ghostball: not run\n\n{error}\n")
        _append("GITHUB_OUTPUT", "verdict=error\n")
        raise
    results, compared = Results.open(out), load_regressions(out)
    changed = changed_scenes(compared)
    outputs = {
        "verdict": VERDICTS.get(status, "error"),
        "changed": " ".join(changed),
        "worst": worst_scene(results, compared),
        "results": str(out.resolve()),  # steps may differ in their working directory
    }
    _append("GITHUB_OUTPUT", "".join(f"{name}={value}\n" for name, value in outputs.items()))
    _append("GITHUB_STEP_SUMMARY", report.printed(out, Format.MARKDOWN))
    written = report.write(out, jobs=processors(AUTO), figures=FigureChoice.NONE.value)
    raise typer.Exit(worst(status, written.status()))


def changed_scenes(compared: Sequence[Regression]) -> list[str]:
    """Return the scenes in which an engine's result differs from its baseline."""
    changes = (change for one in compared for change in one.scenes)
    return list(dict.fromkeys(one.scene for one in changes if one.moved and one.base_hash))


def worst_scene(results: Results, compared: Sequence[Regression]) -> str:
    """Return the scene to look at first; "" if no scene changed and none fails."""
    order = list(CHANGES)
    changes = [
        change for one in compared for change in one.scenes if change.failed or change.base_hash
    ]
    changes = [one for one in changes if one.failed or one.moved]
    changes.sort(key=lambda one: (not one.failed, order.index(one.change), -growth(one)))
    scenes = [one.scene for one in changes] + [one.case.scene for one in failures(results.cases)]
    return scenes[0] if scenes else ""


def _append(variable: str, text: str) -> None:
    """Append to the file that an environment variable of GitHub names, if the variable is set."""
    if name := os.environ.get(variable):
        with Path(name).open("a", encoding="utf-8", newline="\n") as file:
            file.write(text)


if __name__ == "__main__":
    try:
        main()
    except typer.Exit as ended:
        sys.exit(ended.exit_code)
