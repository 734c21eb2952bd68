"""`ghostball regress --against`: run another revision and this one, and compare the results."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape

from ghostball.cli.gate import diff
from ghostball.cli.gate.commands import RegressOptions
from ghostball.cli.options import Format, TextOrJson
from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.terminal import say
from ghostball.model import GhostballError
from ghostball.reports.words import many
from ghostball.validation.baselines.gate import source_of
from ghostball.validation.baselines.revision import checked_out, repository, resolve
from ghostball.validation.baselines.run_pairs import Pair, changes_of, paired
from ghostball.validation.baselines.run_times import Revision, run_time_ratios
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import select

JUDGED = (
    ExitStatus.PASSED,
    ExitStatus.CHECK_FAILED,
    ExitStatus.HARNESS_FAILED,
    ExitStatus.NOT_JUDGED,
)
"""Exit statuses of runs that stored results."""

_IMPORT_CHECK = """\
import os, sys
from ghostball.reference_adapters.registry import engine_class, parse_spec
for label in sys.argv[2:]:
    module = sys.modules[engine_class(parse_spec(label)[0]).__module__]
    file, root = os.path.realpath(module.__file__), os.path.realpath(sys.argv[1])
    if os.path.commonpath([file, root]) != root:
        sys.exit(f"`{label}` is imported from {file}, which is not part of that revision")
"""
"""Program that exits with a message if an engine isn't imported from the given folder."""


def run_both(asked: RegressOptions, labels: Sequence[str], revision: str) -> ExitStatus:
    """Validate at both revisions, print the differences, and return the exit status."""
    config = load_config()
    names = asked.scenes or config.scenes
    select(names)
    here = Path.cwd().resolve()
    root = repository(source_of(labels[0]))
    commit = resolve(revision, root)
    head = (asked.out or config.out).resolve()
    base = head / "against" / commit[:12]
    # Both revisions simulate the same scene files, those of the working directory.
    files = [str(Path(name).resolve()) if Path(name).exists() else name for name in names]
    options = [word for label in labels for word in ("-e", label)]
    options += ["--no-report", "--jobs", str(asked.jobs), "--time-limit", str(asked.time_limit)]
    options += ["--rerun"] * asked.rerun
    with checked_out(root, commit) as place:
        there = place / here.relative_to(root) if here.is_relative_to(root) else place
        if why := _wrong_import(place, there, labels):
            say(f"[bold red]error:[/] can't run revision {commit[:12]}: {why}")
            return ExitStatus.NOT_JUDGED
        status = _validate([*files, *options], base, there)
        if status not in JUDGED:
            return status
        try:
            before = Results.open(base)
        except GhostballError as error:
            say(f"[bold red]error:[/] can't compare with revision {commit[:12]}: {error}")
            return ExitStatus.NOT_JUDGED
        status = _validate([*files, *options], head, here)
        if status not in JUDGED:
            return status
        after = Results.open(head)
        pairs = paired(before, after, {})
        ratios = _ratios(there, here, pairs, asked.time_limit)
    found = changes_of(before, after, pairs)
    shown = TextOrJson.JSON if asked.form is Format.JSON else TextOrJson.TEXT
    return diff.show(str(base), str(head), found, ratios, shown)


def _ratios(there: Path, here: Path, pairs: Sequence[Pair], time_limit: float) -> list[float]:
    """Return the ratios of run times, this revision to the other; the status ignores them."""
    cases = [head for base, head in pairs if base and head and base.bits and head.bits]
    say(f"measuring run times of both revisions alternately, in {many(len(cases), 'shot')}")
    try:
        base, head = (Revision(place, _environment(place)) for place in (there, here))
        return run_time_ratios(base, head, cases, time_limit)
    except GhostballError as error:
        say(f"[yellow]no run times:[/] {escape(str(error))}")
        return []


def _environment(there: Path) -> dict[str, str]:
    paths = [str(there), *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"}


def _wrong_import(place: Path, there: Path, labels: Sequence[str]) -> str:
    """Return why a run in a checkout would not use the code of the checkout; "" if it would.

    `place`: root of the checkout.
    `there`: working directory of the run, inside the checkout.
    """
    asked = subprocess.run(
        [sys.executable, "-c", _IMPORT_CHECK, str(place), *labels],
        cwd=there,
        env=_environment(there),
        capture_output=True,
        text=True,
        check=False,
    )
    said = asked.stderr.strip().splitlines() or ["no message"]
    return said[-1] if asked.returncode else ""


def _validate(arguments: Sequence[str], out: Path, there: Path) -> ExitStatus:
    """Run `ghostball validate` in folder `there` with its code; all its output goes to stderr."""
    out.mkdir(parents=True, exist_ok=True)
    say(f"running the code in {there}")
    ended = subprocess.run(
        [sys.executable, "-m", "ghostball", "validate", *arguments, "--out", str(out)],
        cwd=there,
        env=_environment(there),
        stdout=sys.stderr.fileno(),
        check=False,
    )
    return ExitStatus(ended.returncode) if ended.returncode >= 0 else ExitStatus.HARNESS_FAILED
