"""`ghostball grade --golden`: compare the answers of engines to golden shots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from rich.markup import escape

from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import say, stdout
from ghostball.model import GhostballError
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.run_files import load_object
from ghostball.reports.words import many
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.golden.compare import Comparison, answer_of, compare
from ghostball.validation.golden.format import SCHEMA_FILES, GoldenShot, read_golden

FAULTS_SHOWN = 20
"""Number of failed shots that are printed for an engine; the rest are counted."""

NAMES_SHOWN = 5
"""Number of names that a line lists; the rest are counted."""


def grade_golden(golden: Path, files: Sequence[Path], factor: float | None = None) -> ExitStatus:
    """Compare answers with golden shots, print the failures, and return the exit status.

    An answer that isn't valid fails. A golden shot without an answer isn't judged.

    `factor`: each tolerance is multiplied by this number; None is 1.

    Raises `GhostballError` if the golden shots or the answers can't be read.
    """
    tolerances = 1.0 if factor is None else factor
    if not (math.isfinite(tolerances) and tolerances > 0.0):
        raise GhostballError(f"`--factor` must be finite and greater than 0, got {tolerances}")
    shots = read_golden(golden)
    answers = {path: _answers(path, shots) for path in files}
    judged = {
        path: dict(_judged(path, shots, given, tolerances)) for path, given in answers.items()
    }
    heads = ("answers", "passed", "failed", "no answer", "largest rest error", "in tolerances")
    rows = (_row(path, len(shots), found) for path, found in judged.items())
    # A long path is folded, so that no number is cut on a narrow terminal.
    stdout().print(table_of(heads, rows, right=heads[1:], whole=heads[1:]))
    statuses = []
    for path, found in judged.items():
        failed = {name: one for name, one in found.items() if one.faults}
        for name, one in list(failed.items())[:FAULTS_SHOWN]:
            more = f" (and {many(len(one.faults) - 1, 'more fault')})" * (len(one.faults) > 1)
            line = f"{name} on {path}: {one.faults[0]}{more}"
            stdout().print(f"[bold red]failed[/]  {escape(line)}", soft_wrap=True)
        if (rest := len(failed) - FAULTS_SHOWN) > 0:
            stdout().print(f"        {many(rest, 'more failed shot')} in {escape(str(path))}")
        if not found:
            say(f"[bold yellow]{escape(str(path))} answers none of the golden shots.[/]")
            statuses.append(ExitStatus.NOT_JUDGED)
        elif lacks := [name for name in shots if name not in found]:
            stdout().print(f"no answer in {escape(str(path))}: {_listed(lacks)}", soft_wrap=True)
        statuses.append(ExitStatus.CHECK_FAILED if failed else ExitStatus.PASSED)
    return worst(*statuses)


def _answers(path: Path, shots: Mapping[str, GoldenShot]) -> dict[str, object]:
    """Return the answers in a file or folder, by name of the shot; say which names are unknown."""
    answers: dict[str, object] = {}
    if path.is_dir():
        answers |= {one.stem: one for one in sorted(path.glob("*.json"))}
        for name in SCHEMA_FILES:
            answers.pop(Path(name).stem, None)
    else:
        answers |= load_object(path)
        if "events" in answers:
            raise GhostballError(
                f"{path} holds no answers by name: a single answer belongs in NAME.json in a "
                'folder, or under its name, {"NAME": {"events": ..., "rest_positions": ...}}'
            )
    if unknown := [name for name in answers if name not in shots]:
        close = get_close_matches(unknown[0], shots, n=1, cutoff=0.0)[0]
        names = f"not the name of a golden shot: {_listed(unknown)}. The nearest name to the first"
        say(f"[bold yellow]{escape(str(path))}:[/] {names} is {escape(close)}")
    return {name: one for name, one in answers.items() if name in shots}


def _listed(names: Sequence[str]) -> str:
    """Return the first names as text, and the number of further names."""
    shown = ", ".join(escape(f"{name:.80}") for name in names[:NAMES_SHOWN])
    return shown + f" and {len(names) - NAMES_SHOWN} more" * (len(names) > NAMES_SHOWN)


def _judged(
    path: Path, shots: Mapping[str, GoldenShot], answers: Mapping[str, object], tolerances: float
) -> Iterator[tuple[str, Comparison]]:
    for name, given in answers.items():
        try:
            value = load_object(given) if isinstance(given, Path) else given
            answer = answer_of(shots[name], value, path.stem, "the answer")
        except EngineError as error:
            yield name, Comparison((str(error),), None, None)
        else:
            yield name, compare(shots[name], answer, tolerances)


def _row(path: Path, shots: int, found: Mapping[str, Comparison]) -> tuple[str, ...]:
    failed = sum(bool(one.faults) for one in found.values())
    errors = [one.error for one in found.values() if one.error is not None]
    factors = [one.factor for one in found.values() if one.factor is not None]
    return (
        escape(str(path)),
        str(len(found) - failed),
        str(failed),
        str(shots - len(found)),
        f"{max(errors):.3g} m" if errors else "–",
        f"{max(factors):.3g}" if factors else "–",
    )
