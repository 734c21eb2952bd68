"""`ghostball grade --golden`: compare the answers of engines to golden shots."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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
from ghostball.validation.golden.format import GoldenShot, read_golden

FAULTS_SHOWN = 20
"""Number of failed shots that are printed for an engine; the rest are counted."""


def grade_golden(golden: Path, files: Sequence[Path]) -> ExitStatus:
    """Compare answers with golden shots, print the failures, and return the exit status.

    An answer that isn't valid fails. A golden shot without an answer isn't judged.

    Raises `GhostballError` if the golden shots or the answers can't be read.
    """
    shots = read_golden(golden)
    answers = {path: _answers(path, shots) for path in files}
    judged = {path: dict(_judged(path, shots, given)) for path, given in answers.items()}
    heads = ("answers", "passed", "failed", "no answer", "largest error", "in tolerances")
    rows = (_row(path, len(shots), found) for path, found in judged.items())
    stdout().print(table_of(heads, rows, right=heads[1:]))
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
        statuses.append(ExitStatus.CHECK_FAILED if failed else ExitStatus.PASSED)
    return worst(*statuses)


def _answers(path: Path, shots: Mapping[str, GoldenShot]) -> dict[str, object]:
    """Return the answers in a file or folder, by name of the shot."""
    if path.is_dir():
        return {name: path / f"{name}.json" for name in shots if (path / f"{name}.json").is_file()}
    answers = load_object(path)
    if unknown := [name for name in answers if name not in shots]:
        raise GhostballError(
            f"{path}: `{unknown[0]:.80}` must be the name of a golden shot, such as "
            f"`{next(iter(shots))}`"
        )
    return answers


def _judged(
    path: Path, shots: Mapping[str, GoldenShot], answers: Mapping[str, object]
) -> Iterator[tuple[str, Comparison]]:
    for name, given in answers.items():
        try:
            value = load_object(given) if isinstance(given, Path) else given
            answer = answer_of(shots[name], value, path.stem, name)
        except EngineError as error:
            yield name, Comparison((str(error),), float("inf"), None)
        else:
            yield name, compare(shots[name], answer)


def _row(path: Path, shots: int, found: Mapping[str, Comparison]) -> tuple[str, ...]:
    failed = sum(bool(one.faults) for one in found.values())
    errors = [one.error for one in found.values() if one.error is not None]
    factor = max((one.factor for one in found.values()), default=0.0)
    return (
        escape(str(path)),
        str(len(found) - failed),
        str(failed),
        str(shots - len(found)),
        f"{max(errors):.3g} m" if errors else "–",
        f"{factor:.3g}",
    )
