"""Compares an engine as it is here with another revision: both run by turns, in one go."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ghostball.engine import Result, Scene
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.baselines.bands import Bands, band_of_counter, band_of_metric
from ghostball.validation.baselines.baseline import engine_key
from ghostball.validation.baselines.classify import classify
from ghostball.validation.baselines.gate import allowance, outcome_of, source_of
from ghostball.validation.baselines.observed import Observed
from ghostball.validation.baselines.player import NotComparableError, Player, PlayError, playing
from ghostball.validation.baselines.regression import Regression, SceneChange, TimeChange
from ghostball.validation.baselines.replay import PlayAgain, not_deterministic, playing_again
from ghostball.validation.baselines.revision import repository, resolve, worktree
from ghostball.validation.baselines.timing import (
    ROUNDS,
    RUNS,
    compare_samples,
)
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.metrics import measure
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.motions import save_sides
from ghostball.validation.results.records import Motion
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes import commands
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.truth.scene_truth import OUR_NAME, Truth, truth_of

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class _Shot:
    """A scene, where it lies, and how both sides played it."""

    scene: Scene
    path: Path
    truth: Truth
    base: Result | PlayError
    head: Result


def compare_revisions(
    scenes: Sequence[Scene],
    revision: str,
    out: Path,
    label: str = OUR_NAME,
    *,
    criteria: Mapping[str, Criteria] | None = None,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
    time_limit: float | None = None,
) -> Regression:
    """Run scenes on another revision and on the engine as it is here, and compare.

    Parameters
    ----------
    scenes : sequence of Scene
    revision : str
        Any name that git knows.
    out : Path
        A results folder; the motion of both sides goes into it.
    label : str
        The engine, as it was asked for; the revision is of the repository that its code is in.
    criteria : mapping of str to Criteria, optional
        By scene name; those of shipped scenes where left out.
    rounds : int
        How often each scene is timed; 0: not at all.
    progress : callable, optional
    time_limit : float or None [s]
        As of `gate.compare_results`.

    Raises
    ------
    RevisionError
        Where there is no such revision.
    NotComparableError
        Where it can't be built or run.
    """
    source = source_of(label)
    root = repository(source)
    imported_from = source.parent.parent if source.stem == "__init__" else source.parent
    below = imported_from.relative_to(root).as_posix()
    commit = resolve(revision, root)
    planned, done = 2 * len(scenes) + rounds, 0

    def one_more(last: str) -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, planned, last)

    with tempfile.TemporaryDirectory() as place, worktree(root, commit) as there:
        sides = {f"revision {commit[:12]}": there, "the engine here": root}
        with _playing(sides, label, below) as (base, head):
            shots = []
            for scene in scenes:
                own = (criteria or {}).get(scene.name)
                shots.append(_play(scene, Path(place), base, head, own))
                one_more(scene.name)
            if shots and not any(isinstance(shot.base, Result) for shot in shots):
                raise NotComparableError(
                    f"revision {commit[:12]} can play none of these scenes: {shots[0].base}"
                )
            ended = _ended(shots) if rounds else []
            times = _by_turns(ended, base, head, rounds, one_more)
        doubtful = [shot for shot in ended if times[shot.scene.name].slower]
        if doubtful:
            # Where memory lies costs time, and is another place in each process.
            with _playing(sides, label, below) as (base, head):
                times |= _by_turns(doubtful, base, head, rounds, lambda _: None)
    changes = []
    motions: dict[tuple[str, str], Motion] = {}
    with playing_again(label, time_limit) as play_again:
        for shot in shots:
            change = _change(shot, times.get(shot.scene.name), revision, label, play_again)
            changes.append(change)
            if change.base_hash != change.head_hash and isinstance(shot.base, Result):
                for side, result in (("base", shot.base), ("head", shot.head)):
                    motions[shot.scene.name, side] = motion_of(result)
            one_more(f"comparing {shot.scene.name}")
    save_sides(out, motions)
    environment = describe_environment()
    return Regression(
        label=label,
        engine=engine_key(label),
        against=revision,
        base={**environment, "git": {"revision": commit, "dirty": False}},
        head=environment,
        outcome=outcome_of(changes),
        scenes=tuple(changes),
    )


def _play(
    scene: Scene, place: Path, base: Player, head: Player, criteria: Criteria | None
) -> _Shot:
    path = place / f"{len(list(place.iterdir()))}.toml"
    scene.save(path)
    wanted = (shipped_criteria(scene) if criteria is None else criteria).truth
    truth = truth_of(scene, wanted)
    before: Result | PlayError
    try:
        before = base.play(scene, path)
    except PlayError as error:
        before = error
    return _Shot(scene, path, truth, before, head.play(scene, path))


def _ended(shots: Sequence[_Shot]) -> list[_Shot]:
    """Return the shots that end by themselves on both sides: the time to a limit says nothing."""
    return [
        shot
        for shot in shots
        if isinstance(shot.base, Result) and shot.base.status.complete and shot.head.status.complete
    ]


@contextmanager
def _playing(sides: Mapping[str, Path], label: str, below: str) -> Iterator[tuple[Player, Player]]:
    """Start both sides, the base first, each in a process of its own."""
    with ExitStack() as stack:
        base, head = (
            stack.enter_context(playing(name, root, label, below)) for name, root in sides.items()
        )
        yield base, head


def _by_turns(
    shots: Sequence[_Shot],
    base: Player,
    head: Player,
    rounds: int,
    one_more: Callable[[str], None],
) -> dict[str, TimeChange]:
    """Time both sides by turns."""
    samples: dict[str, tuple[list[float], list[float]]] = {
        shot.scene.name: ([], []) for shot in shots
    }
    for turn in range(rounds):
        _one_round(shots, base, head, turn, samples)
        one_more(f"timing, round {turn + 1}")
    return {name: compare_samples(*taken) for name, taken in samples.items()}


def _one_round(
    shots: Sequence[_Shot],
    base: Player,
    head: Player,
    turn: int,
    samples: Mapping[str, tuple[list[float], list[float]]],
) -> None:
    """Time each shot on both sides, the first of both changing from round to round."""
    for shot in shots:
        before, after = samples[shot.scene.name]
        sides = [(base, before), (head, after)]
        for player, taken in sides if turn % 2 == 0 else reversed(sides):
            taken.append(player.seconds(shot.path, RUNS))


def _change(
    shot: _Shot, time: TimeChange | None, revision: str, label: str, play_again: PlayAgain
) -> SceneChange:
    scene = shot.scene
    command = commands.regress(scene.name, revision, label)
    if isinstance(shot.base, PlayError):
        return SceneChange(
            scene=scene.name,
            title=scene.title,
            change="not-comparable",
            failed=False,
            summary=str(shot.base),
            command=command,
        )
    head, base = (_observed(result, shot.truth, label) for result in (shot.head, shot.base))
    unsteady = not_deterministic(head, base.bits, play_again, scene, command)
    if unsteady is not None:
        return unsteady.model_copy(update={"time": time})
    bands = Bands(
        {name: band_of_metric(name, base.metrics) for name in base.metrics},
        {name: band_of_counter(count) for name, count in base.work.items()},
    )
    change = classify(base, head, bands, lambda: allowance(scene, head, label), command)
    update: dict[str, Any] = {"time": time}
    if time is not None and time.slower:
        update["failed"] = True
        update["summary"] = f"{change.summary}; {time.words}"
    return change.model_copy(update=update)


def _observed(result: Result, truth: Truth, label: str) -> Observed:
    horizon = truth.horizon_of(resolution_of(make_engine(label), result.scene))
    return Observed.of_result(result, measure(result, truth, horizon=horizon).values, truth.kind)
