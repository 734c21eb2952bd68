"""The commands that say what moved, and keep what is accepted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ghostball.cli.options import (
    BaselineFolder,
    FailOnChoice,
    GuardedEngines,
    Plain,
    PlainFormat,
    SceneNames,
    SuiteOptions,
    out_option,
    scene_argument,
)
from ghostball.cli.shared.calls import command

app = typer.Typer()


@command(app, "gate.regress")
@dataclass(frozen=True)
class RegressOptions(SuiteOptions):
    """Say what changed in an engine since its baselines were accepted.

    The same run as `validate`, in the same folder, that asks for a baseline of each scene. A scene
    is unchanged, moved by rounding only, better or worse than it was, has wrong collisions, or
    changed in a way that no reference result judges. The first event that differs is named. Exit
    status 1 if a scene changed, or a work counter did, unless `--fail-on` asks for less; rounding
    fails only of Ghostball's own engine. Exit status 4 if a scene can't be compared, such as one
    without a baseline.
    """

    scenes: SceneNames = None
    engine: GuardedEngines = None
    against: Annotated[
        str | None,
        typer.Option(
            metavar="REV",
            help="Validate at another revision too, and say what differs, instead of comparing "
            "with baselines. The results of that revision are in OUT/against. The run times of "
            "both revisions are measured by turns; they decide nothing.",
        ),
    ] = None
    baselines: BaselineFolder = None
    fail_on: Annotated[
        FailOnChoice | None,
        typer.Option(
            help="What fails: whatever changed; of that only larger errors and wrong collisions; "
            "or only failed limits, and shots that the engine did not finish, for which no "
            "baseline is needed (default: that of [tool.ghostball] in pyproject.toml, else "
            "changed)."
        ),
    ] = None
    out: Annotated[Path | None, out_option("Folder of the results (default: out).")] = None


@command(app, "gate.accept")
@dataclass(frozen=True)
class AcceptOptions:
    """Accept what the last run found, and note why.

    The baselines that changed are rewritten. If a result fails a limit on its error, nothing is
    written, and the exit status is 1. If the engine did not finish a scene, the scene is named, the
    other scenes are accepted, and the exit status is 1.
    """

    reason: Annotated[
        str, typer.Option(metavar="TEXT", help="Why the change is right; kept in CHANGES.md.")
    ]
    scenes: Annotated[
        list[str] | None,
        scene_argument(
            "SCENE", "Accept only these, by name or pattern such as 'break-*' (default: all)."
        ),
    ] = None
    engine: GuardedEngines = None
    out: Annotated[
        Path | None,
        out_option(
            "Folder that `regress` or `validate` wrote and that you have reviewed (default: out)."
        ),
    ] = None
    baselines: BaselineFolder = None
    even_though_limits_fail: Annotated[
        bool,
        typer.Option(
            "--even-though-limits-fail",
            help="Accept even results that fail a limit on the error, so are wrong, and results "
            "that no limit judges.",
        ),
    ] = False


@command(app, "gate.diff")
@dataclass(frozen=True)
class DiffOptions:
    """Compare two runs, or two engines, scene by scene.

    Each scene has the answer that `regress` would give. Exit status 1 if a case of B is less
    accurate by a class, or fails where A does not.
    """

    first: Annotated[str, typer.Argument(metavar="A", help="A results folder, or an engine.")]
    second: Annotated[str, typer.Argument(metavar="B", help="A second one of the same kind.")]
    out: Annotated[
        Path | None, out_option("Folder that has the results of both engines (default: out).")
    ] = None
    form: PlainFormat = Plain.TEXT
