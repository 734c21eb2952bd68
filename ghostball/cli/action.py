"""What `action.yml` runs for a project that is guarded on GitHub: `python -m ghostball.cli.action`.

It is `ghostball regress`, of which it says what GitHub asks for: notes in the run of the workflow,
a summary of the step, a page to be kept, and outputs for the steps that follow. Inputs are
environment variables, `INPUT_ENGINE` and so on; where outputs and summary go is in GitHub's own.
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
from ghostball.reports.outcome import CHANGES, failures
from ghostball.reports.shift import growth
from ghostball.validation.baselines import Regression, load_regressions
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.store import Results

VERDICTS = {
    ExitStatus.PASSED: "passed",
    ExitStatus.CHECK_FAILED: "failed",
    ExitStatus.NOT_JUDGED: "not-judged",
}
"""What the output `verdict` says; anything else is "error"."""


def asked_by(given: Mapping[str, str]) -> RegressOptions:
    """Return what environment variables ask for; raises `ConfigError` where one is nonsense."""
    texts = {
        name: given.get(f"INPUT_{name.upper()}", "").strip()
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
    """Judge, say it in all of GitHub's ways, and end with the status of `ghostball regress`."""
    try:
        status, out = regress.run(asked_by(os.environ)), load_config().out
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
        "results": str(out.resolve()),  # not every step has the same working directory
    }
    _append("GITHUB_OUTPUT", "".join(f"{name}={value}\n" for name, value in outputs.items()))
    _append("GITHUB_STEP_SUMMARY", report.printed(out, Format.MARKDOWN))
    written = report.write(out, jobs=processors(AUTO), figures=FigureChoice.NONE.value)
    raise typer.Exit(worst(status, written.status()))


def changed_scenes(compared: Sequence[Regression]) -> list[str]:
    """Return the scenes in which an engine did something else than its baseline says."""
    changes = (change for one in compared for change in one.scenes)
    return list(dict.fromkeys(one.scene for one in changes if one.moved and one.base_hash))


def worst_scene(results: Results, compared: Sequence[Regression]) -> str:
    """Return the scene that is to be looked at first; "" where none moved, and none fails."""
    order = list(CHANGES)
    changes = [
        change for one in compared for change in one.scenes if change.failed or change.base_hash
    ]
    changes = [one for one in changes if one.failed or one.moved]
    changes.sort(key=lambda one: (not one.failed, order.index(one.change), -growth(one)))
    scenes = [one.scene for one in changes] + [one.case.scene for one in failures(results.cases)]
    return scenes[0] if scenes else ""


def _append(variable: str, text: str) -> None:
    """Append to the file that GitHub names; elsewhere there is none."""
    if name := os.environ.get(variable):
        with Path(name).open("a", encoding="utf-8", newline="\n") as file:
            file.write(text)


if __name__ == "__main__":
    try:
        main()
    except typer.Exit as ended:
        sys.exit(ended.exit_code)
