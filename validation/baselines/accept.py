"""Accept the results of the last comparison: rewrite baselines and record the reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.validation.baselines.baseline import (
    Accepted,
    Baseline,
    BaselineSchemaError,
    baseline_path,
    load_baseline,
)
from ghostball.validation.baselines.gate import Gate, accepted_now, compared_run_in, sources_hash
from ghostball.validation.baselines.regression import Regression, SceneChange, load_regression
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.files import write_files
from ghostball.validation.results.store import Results

CHANGES_FILE = "CHANGES.md"

_HEAD = """\
# Accepted changes, with reasons

Newest first. A change is *rounding* if no state up to the predictability horizon changed by more
than rounding explains; *better* or *worse* if the error against the reference result changed.
"""


class AcceptError(GhostballError, ValueError):
    """Nothing can be accepted: the input is wrong, or the comparison is out of date."""


class NothingToAcceptError(AcceptError):
    """No selected scene has a change that could be accepted."""


class RefusedError(AcceptError):
    """Results that must not be accepted; `status` is the exit status of the command."""

    def __init__(self, message: str, status: ExitStatus = ExitStatus.CHECK_FAILED) -> None:
        super().__init__(f"nothing was accepted: {message}")
        self.status = status


@dataclass(frozen=True)
class Acceptance:
    """Result of accepting a comparison.

    `written`: scenes with a new or rewritten baseline.
    `left`: scenes that changed too, but were not selected.
    `broken`: the accepted scenes whose results fail limits on the error.
    `unfinished`: selected scenes that the engine did not finish, so there was no result to accept.
    """

    written: tuple[str, ...]
    left: tuple[str, ...]
    broken: tuple[SceneChange, ...]
    unfinished: tuple[SceneChange, ...]
    changelog: Path


def accept(
    results: Path,
    reason: str,
    gate: Gate,
    *,
    only: Sequence[str] = ("*",),
    even_though_limits_fail: bool = False,
) -> Acceptance:
    """Accept the changes that a comparison of an engine with its baselines found.

    `results`: the results folder of the comparison.
    `reason`: why the change is right: a sentence for later readers.
    `only`: names or patterns of the selected scenes.
    `even_though_limits_fail`: accept results even if they fail limits, or if no limit judges them.

    Raises `RefusedError` if a selected result fails a limit on its error, if no limit judges any of
    them, if the engine gave different results when it simulated a selected scene twice, or if the
    engine finished none of the selected scenes that changed. Raises `AcceptError` if the reason is
    empty, if there is no comparison, if the code or the results in the folder are newer than the
    comparison, or if there is nothing to accept. Nothing is written in these cases. Raises
    `ResultsError` if a file can't be written.
    """
    if not reason.strip():
        raise AcceptError(
            "`reason` must not be empty. Say why the change is right, for example --reason "
            '"the root finder polishes once more"'
        )
    regression = _regression_in(results, gate)
    accepted, run = accepted_now(regression.head, reason), Results.open(results)
    asked = [one for one in regression.scenes if _is_any(one.scene, only)]
    if unsteady := [one.scene for one in asked if one.change == "not-deterministic"]:
        raise RefusedError(
            f"engine `{gate.engine}` gives a different result each time it simulates "
            f"{', '.join(unsteady)}, so no baseline can be kept. Make the engine deterministic, "
            "and run `ghostball regress` again. To accept other scenes, name them"
        )
    others = (one for one in regression.scenes if one not in asked and one.can_be_accepted)
    left = tuple(one.scene for one in others if _is_left(one, gate))
    baselines = {
        one.scene: _baseline_of(one, run, accepted, gate) for one in asked if one.can_be_accepted
    }
    chosen = [
        one
        for one in asked
        if one.scene in baselines and not _was_accepted(one, baselines[one.scene], gate)
    ]
    lost = [one for one in asked if one.failed and not one.head_hash]
    if not chosen:
        if lost:
            said = "; ".join(f"{one.scene}: {one.summary}" for one in lost)
            raise RefusedError(
                f"{gate.engine}: {said}. Fix the engine, and run `ghostball regress` again"
            )
        raise NothingToAcceptError(
            f'the selected scenes ("{" ".join(only)}") have no change to accept; other scenes with '
            f"changes: {', '.join(left) or 'none'}"
        )
    broken = [one for one in chosen if one.broken]
    if not even_though_limits_fail:
        _refuse_failing(broken, regression.unjudged)
    texts = {baseline_path(gate.folder, one.scene): baselines[one.scene].text for one in chosen}
    changelog = gate.folder / CHANGES_FILE
    texts[changelog] = _with_entry(changelog, _entry(accepted, chosen))
    write_files(texts, "Choose another `--baselines`")
    written = tuple(one.scene for one in chosen)
    return Acceptance(written, left, tuple(broken), tuple(lost), changelog)


def _regression_in(results: Path, gate: Gate) -> Regression:
    """Return the stored comparison of an engine; the code must be the same as then."""
    regression = load_regression(results, gate.engine)
    if regression is None:
        raise AcceptError(
            f"{results}: contains no comparison of engine `{gate.engine}`, so there is nothing to "
            "accept. Run `ghostball regress` with the same `--engine` and `--out`, and review its "
            "output"
        )
    if regression.head.get("sources") != sources_hash(regression.label):
        raise AcceptError(
            f"{results}: the code has changed since that comparison, so its results are out of "
            "date. Run `ghostball regress` again, and review its output"
        )
    return regression


def _refuse_failing(broken: Sequence[SceneChange], unjudged: str) -> None:
    """Raise `RefusedError` if results fail limits, or if no limit judges them."""
    if broken:
        said = "".join(f"\n  {one.scene}: {'; '.join(one.broken)}" for one in broken)
        raise RefusedError(
            "results fail limits on the error, so they are wrong, not only different:"
            f"{said}\nFix the engine. To accept other scenes, name them, or use "
            "--even-though-limits-fail"
        )
    if unjudged:
        raise RefusedError(f"{unjudged}, or use --even-though-limits-fail", ExitStatus.NOT_JUDGED)


def _is_any(scene: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(scene, pattern) for pattern in patterns)


def _baseline_of(change: SceneChange, run: Results, accepted: Accepted, gate: Gate) -> Baseline:
    """Return the baseline that accepts a run; the run must be the one that was compared."""
    played = compared_run_in(run, gate, change.scene)
    if played.record.bits != change.head_hash:
        raise AcceptError(
            f"{change.scene}: its run isn't the one that was compared, so nobody has reviewed "
            "these results. Run `ghostball regress` again, and review its output"
        )
    return Baseline.of(played, accepted, gate.engine)


def _baseline_now(change: SceneChange, gate: Gate) -> Baseline | None:
    """Return the present baseline of a scene; None: no baseline, or one of another version."""
    path = baseline_path(gate.folder, change.scene)
    try:
        return load_baseline(path, gate.engine) if path.exists() else None
    except BaselineSchemaError:
        return None


def _is_left(change: SceneChange, gate: Gate) -> bool:
    """Return False if a change outside the selection was accepted since the comparison."""
    now = _baseline_now(change, gate)
    if now is None:
        return True
    if change.base_hash == change.head_hash:  # equal hashes: only counters changed
        counters = change.counters
        return not counters or any(now.record.work.get(one.name) != one.head for one in counters)
    return now.record.bits != change.head_hash


def _was_accepted(change: SceneChange, baseline: Baseline, gate: Gate) -> bool:
    """Return True if the same baseline exists already, ignoring its date and reason."""
    now = _baseline_now(change, gate)
    if now is not None and now.hash == baseline.hash:
        return True
    if change.base_hash != ("" if now is None else now.record.bits):
        raise AcceptError(
            f"{baseline_path(gate.folder, change.scene)}: differs from the baseline that was "
            "compared: it has been accepted, restored or removed since then, or `--baselines` was "
            "a different folder. Run "
            "`ghostball regress` again"
        )
    return False


def _entry(accepted: Accepted, changes: Sequence[SceneChange]) -> str:
    """Return the entry of the changelog for the accepted changes."""
    lines = [f"## {accepted.date}, revision {accepted.revision}", "", accepted.reason, ""]
    lines += [f"On {accepted.platform}.", ""]
    new = [change.scene for change in changes if change.change == "no-baseline"]
    lines += [
        f"* {one.scene}: {one.words}; {one.summary}" for one in changes if one.scene not in new
    ]
    lines += [f"* New: {', '.join(new)}"] * bool(new)
    return "\n".join([*lines, ""])


def _with_entry(changelog: Path, entry: str) -> str:
    """Return the changelog with a new entry on top."""
    try:
        text = read_text(changelog)
    except FileNotFoundError:
        text = _HEAD
    except (OSError, UnicodeDecodeError) as error:
        raise AcceptError(f"{changelog}: can't be read: {error}. Fix or remove it") from None
    head, mark, rest = text.partition("\n## ")
    return head.rstrip("\n") + "\n\n" + entry + (f"\n## {rest}" if mark else "")
