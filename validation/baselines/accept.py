"""Accepts what the last run found: rewrites baselines, and says why in their changelog."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from pathlib import Path

from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.baselines.baseline import (
    Accepted,
    Baseline,
    BaselineSchemaError,
    baseline_of,
    load_baseline,
)
from ghostball.validation.baselines.gate import platform_of, revision_of, sources_hash
from ghostball.validation.baselines.places import baseline_path
from ghostball.validation.baselines.regression import Regression, SceneChange, load_regression
from ghostball.validation.results.files import write_all_whole

CHANGES_FILE = "CHANGES.md"

_HEAD = """\
# What was accepted, and why

Newest first. A change is *rounding-only* where no state up to the predictability horizon moved by
more than rounding explains; *better* or *worse* where it moved against truth.
"""


class AcceptError(GhostballError, ValueError):
    """Nothing that can be accepted."""


class NothingToAcceptError(AcceptError):
    """A comparison in which nothing moved that isn't accepted yet."""


class NotDeterministicError(AcceptError):
    """What was to be accepted is something else each time that the engine plays it."""


class NotFinishedError(AcceptError):
    """What was to be accepted has no result: the engine crashed, hung or gave up."""


class UnjudgedError(AcceptError):
    """No limit judged the results to be accepted, so nothing shows that they are right."""


class LimitsBrokenError(AcceptError):
    """Results to be accepted fail limits on the error, in the scenes `broken`."""

    def __init__(self, broken: Sequence[SceneChange]) -> None:
        self.broken = tuple(broken)
        said = "".join(f"\n  {one.scene}: {'; '.join(one.broken)}" for one in broken)
        super().__init__(
            "nothing was accepted: results fail limits on the error, so they are wrong, not only "
            f"different:{said}\nFix the engine. To accept other scenes, name them"
        )


@dataclass(frozen=True)
class Acceptance:
    """What was accepted.

    `written`, `deleted`: scenes whose baselines were rewritten, or made; and that have none any
        more.
    `left`: scenes that moved too, and weren't asked for.
    `broken`: the accepted scenes whose results fail limits on the error.
    `unfinished`: those that were asked for and that the engine did not finish: no result was there
        to accept.
    """

    written: tuple[str, ...]
    deleted: tuple[str, ...]
    left: tuple[str, ...]
    broken: tuple[SceneChange, ...]
    unfinished: tuple[SceneChange, ...]
    changelog: Path


def accept(
    results: Path,
    reason: str,
    *,
    only: Sequence[str] = ("*",),
    folder: Path,
    engine: str = OURS,
    even_though_limits_fail: bool = False,
) -> Acceptance:
    """Accept what a comparison with baselines found.

    `results`: the results folder of that comparison.
    `reason`: why the change is right; a sentence for those who come after.
    `only`: names or patterns of scenes.
    `folder`: of the baselines of the engine.
    `engine`: the one that is meant; see `baseline.engine_key`.
    `even_though_limits_fail`: whether to accept even results that fail limits, or that no limit
        judges.

    Raises `LimitsBrokenError` if a result to be accepted fails a limit on its error;
    `UnjudgedError` if no limit judges any of them;
    `NotDeterministicError` where the engine gave other bits when it played one of the scenes again;
    `NotFinishedError` where there is no more to accept than what the engine did not finish;
    `GhostballError` where there is no reason, no comparison, one of other code than what is here
    now, or nothing to accept. Nothing is written then.
    """
    if not reason.strip():
        raise AcceptError(
            "`reason` must say why the change is right, got nothing. Say it as in --reason "
            '"the root finder polishes once more"'
        )
    regression = load_regression(results, engine)
    if regression is None:
        raise AcceptError(
            f"{results}: holds no comparison of engine `{engine}`, so there is nothing to accept. "
            "Run `ghostball regress` with the same `--engine` and `--out`, and look at what it says"
        )
    if regression.head.get("sources") != sources_hash(regression.label):
        raise AcceptError(
            f"{results}: the code changed since that comparison, so what it found is not what "
            "would be accepted. Run `ghostball regress` again, and look at what it says"
        )
    unsteady = [one.scene for one in regression.scenes if one.change == "not-deterministic"]
    if unsteady := [name for name in unsteady if _is_any(name, only)]:
        raise NotDeterministicError(
            f"nothing was accepted: engine `{engine}` gives a different result each time it "
            f"simulates {', '.join(unsteady)}, so no baseline holds. Make it deterministic, and "
            "run `ghostball regress` again. To accept other scenes, name them"
        )
    accepted = _accepted(regression, reason)
    candidates = _candidates(regression, results, folder)
    chosen = [one for one in candidates if _is_any(one.scene, only)]
    left = [name for name in regression.stale if baseline_path(folder, name).exists()]
    stale = [name for name in left if _is_any(name, only)]
    lost = [one for one in regression.scenes if one.failed and not one.head_hash]
    lost = [one for one in lost if _is_any(one.scene, only)]
    if not chosen and not stale:
        if lost:
            said = "; ".join(f"{one.scene}: {one.summary}" for one in lost)
            raise NotFinishedError(
                f"nothing was accepted for engine `{engine}`: {said}. Fix the engine, and run "
                "`ghostball regress` again"
            )
        there = ", ".join([*(one.scene for one in candidates), *left]) or "nothing"
        raise NothingToAcceptError(
            f'nothing to accept matches "{" ".join(only)}"; what there is to accept: {there}'
        )
    names = {one.scene for one in chosen}
    broken = [one for one in regression.broken if one.scene in names]
    if broken and not even_though_limits_fail:
        raise LimitsBrokenError(broken)
    if chosen and regression.unjudged and not even_though_limits_fail:
        raise UnjudgedError(f"nothing was accepted: {regression.unjudged}")
    entry = _entry(regression, accepted, [one.scene for one in chosen], stale)
    changelog = folder / CHANGES_FILE
    texts = {
        baseline_path(folder, one.scene): one.model_copy(update={"accepted": accepted}).text()
        for one in chosen
    }
    texts[changelog] = _with_entry(changelog, entry)
    _write(texts, [baseline_path(folder, name) for name in stale])
    return Acceptance(
        tuple(one.scene for one in chosen),
        tuple(stale),
        tuple(one.scene for one in candidates if one not in chosen),
        tuple(broken),
        tuple(lost),
        changelog,
    )


def _is_any(scene: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(scene, pattern) for pattern in patterns)


def can_be_accepted(change: SceneChange) -> bool:
    """Whether something moved that a baseline holds: broken limits, or times, alone are nothing."""
    if change.change == "not-deterministic":
        return False
    return bool(change.head_hash) and change.moved


def _accepted(regression: Regression, reason: str) -> Accepted:
    return Accepted(
        date=datetime.now(UTC).date().isoformat(),
        revision=revision_of(regression.head),
        platform=platform_of(regression.head),
        reason=" ".join(reason.split()),
    )


def _candidates(regression: Regression, results: Path, folder: Path) -> list[Baseline]:
    """Return what would be accepted, but for what was accepted before."""
    found = []
    for change in regression.scenes:
        if change.candidate:
            path = baseline_path(folder, change.scene)
            candidate = baseline_of(change.candidate, path, regression.engine)
            if not _was_accepted(change, candidate, path):
                found.append(candidate)
        elif can_be_accepted(change):
            raise AcceptError(
                f"{results}: holds no baseline to write for {change.scene}. Run `ghostball "
                f"regress --out {results}`"
            )
    return found


def _was_accepted(change: SceneChange, candidate: Baseline, path: Path) -> bool:
    """Whether a candidate is the baseline already, but for when and why it was accepted."""
    before = ""
    if path.exists():
        try:
            now = load_baseline(path, candidate.engine)
        except BaselineSchemaError:
            return False
        if now.model_copy(update={"accepted": candidate.accepted}) == candidate:
            return True
        before = now.hash.bits
    if change.base_hash != before:
        raise AcceptError(
            f"{path}: isn't what was compared with: it was accepted, restored or removed since, or "
            "`--baselines` was another folder. Run `ghostball regress` again"
        )
    return False


def _entry(
    regression: Regression, accepted: Accepted, scenes: Sequence[str], stale: Sequence[str]
) -> str:
    """Return what the changelog says of it."""
    lines = [
        f"## {accepted.date}, revision {accepted.revision}",
        "",
        accepted.reason,
        "",
        f"On {accepted.platform}.",
        "",
    ]
    changes = [change for change in regression.scenes if change.scene in scenes]
    new = [change.scene for change in changes if change.change == "no-baseline"]
    moved = [change for change in changes if change.change != "no-baseline"]
    if moved:
        lines += ["| scene | change | what moved |", "|---|---|---|"]
        lines += [
            f"| {one.scene} | {_words(one)} | {one.summary.replace('|', '/')} |" for one in moved
        ]
        lines.append("")
    if new:
        lines += [f"New: {', '.join(new)}.", ""]
    if stale:
        lines += [f"No more: {', '.join(stale)}.", ""]
    return "\n".join(lines)


def _words(change: SceneChange) -> str:
    """Return what the changelog calls a change: the same bits may have cost other work."""
    return "same bits, other work" if change.change == "identical" else change.change


def _with_entry(changelog: Path, entry: str) -> str:
    """Return the changelog with a new entry on top."""
    try:
        text = read_text(changelog)
    except FileNotFoundError:
        text = _HEAD
    except (OSError, UnicodeDecodeError) as error:
        raise AcceptError(f"{changelog}: can't be read: {error}. Mend or remove it") from None
    head, mark, rest = text.partition("\n## ")
    return head.rstrip("\n") + "\n\n" + entry + (f"\n## {rest}" if mark else "")


def _write(texts: dict[Path, str], stale: Sequence[Path]) -> None:
    """Write all files, none before all are on the disk, then remove stale ones."""
    try:
        for path in texts:
            path.parent.mkdir(parents=True, exist_ok=True)
        write_all_whole(texts)
        for path in stale:
            path.unlink(missing_ok=True)
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise AcceptError(
            f"{error.filename or next(iter(texts)).parent}: can't be written: {reason}. Choose "
            "another `--baselines`"
        ) from error
