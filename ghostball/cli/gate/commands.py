"""Options and help of `regress`, `accept` and `diff`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ghostball.cli.options import (
    FAIL_ON_MEANINGS,
    BaselineFolder,
    FailOnChoice,
    GuardedEngines,
    SceneNames,
    SuiteOptions,
    TextOrJson,
    TextOrJsonOption,
    out_option,
    scene_argument,
)
from ghostball.cli.shared.calls import command

app = typer.Typer()


@command(app, "gate.regress")
@dataclass(frozen=True)
class RegressOptions(SuiteOptions):
    """Show what changed in an engine since its baselines were accepted.

    The command runs the scenes as `validate` does, into the same folder, and compares each with its
    baseline. The answer for a scene is unchanged, changed by rounding only, better, worse, or wrong
    collisions; or changed, if the errors don't show which result is better. The output names the
    first event that differs. Exit status 1 if a scene or a work counter changed, unless `--fail-on`
    is more lenient. A change by rounding alone fails for Ghostball's own engine, but passes for
    other engines. Exit status 4 if a scene can't be compared, for example because it has no
    baseline.
    """

    scenes: SceneNames = None
    engine: GuardedEngines = None
    against: Annotated[
        str | None,
        typer.Option(
            metavar="REV",
            help="Compare with another revision of the code instead of with baselines: run both "
            "and show what differs. The results of that revision are in OUT/against. The run "
            "times of both revisions are measured alternately; they don't affect the exit status.",
        ),
    ] = None
    baselines: BaselineFolder = None
    fail_on: Annotated[
        FailOnChoice | None,
        typer.Option(
            help="What fails the comparison. "
            f"{'. '.join(map(': '.join, FAIL_ON_MEANINGS.items()))}. "
            "(Default: that of [tool.ghostball] in pyproject.toml, else changed.)"
        ),
    ] = None
    out: Annotated[Path | None, out_option("Results folder (default: out).")] = None


@command(app, "gate.accept")
@dataclass(frozen=True)
class AcceptOptions:
    """Accept the results of the last run as baselines, with a reason.

    The baselines that changed are rewritten. If a result fails a limit on its error, nothing is
    written, and the exit status is 1. If the engine did not finish a scene, the scene is named, the
    other scenes are accepted, and the exit status is 1.
    """

    reason: Annotated[
        str, typer.Option(metavar="TEXT", help="Why the change is right; recorded in CHANGES.md.")
    ]
    scenes: Annotated[
        list[str] | None,
        scene_argument(
            "SCENE", "Scenes to accept: names, or patterns such as 'break-*' (default: all)."
        ),
    ] = None
    engine: GuardedEngines = None
    out: Annotated[
        Path | None,
        out_option("Results folder of `regress` that you have reviewed (default: out)."),
    ] = None
    baselines: BaselineFolder = None
    even_though_limits_fail: Annotated[
        bool,
        typer.Option(
            "--even-though-limits-fail",
            help="Also accept results that fail a limit on the error, and results that no limit "
            "judges.",
        ),
    ] = False


@command(app, "gate.diff")
@dataclass(frozen=True)
class DiffOptions:
    """Compare two runs, or two engines, scene by scene.

    Changes have the same names as in `regress`. Exit status 1 if a case has a worse accuracy class
    in B than in A, or fails only in B.
    """

    first: Annotated[str, typer.Argument(metavar="A", help="Results folder or engine.")]
    second: Annotated[str, typer.Argument(metavar="B", help="The other results folder or engine.")]
    out: Annotated[
        Path | None, out_option("Results folder with the results of both engines (default: out).")
    ] = None
    form: TextOrJsonOption = TextOrJson.TEXT
