"""Runs of ensembles: the same members everywhere, what is done is kept, nothing costs more."""

import json
from pathlib import Path

import numpy as np
import pytest

import ghostball.validation.ensembles.run as run_module
from ghostball.engine import GhostballError, Scene, simulate
from ghostball.validation.ensembles import (
    EnsembleError,
    Ensembles,
    Size,
    check_ensembles,
    compare,
    perturb,
    run_ensembles,
)
from ghostball.validation.ensembles.run import EnsembleOutcome
from ghostball.validation.results.database import transaction, writing
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.frames import rows_of
from ghostball.validation.scenes.library import find_scene

BOTH = ["ghostball", "fake"]


def loaded(folder: Path) -> Ensembles:
    ensembles = Ensembles.load(folder)
    assert ensembles is not None
    return ensembles


def content(folder: Path) -> list[str]:
    """Every member, and of which ensemble it is."""
    return sorted(json.dumps(row) for row in rows_of(folder, "members"))


# --- what is run


def test_every_engine_runs_the_members_and_ours_others_too(roll: Scene, folder: Path):
    seen: list[tuple[int, int]] = []
    outcome = run_ensembles(
        [roll], BOTH, folder, 5, progress=lambda done, planned, _: seen.append((done, planned))
    )
    assert outcome == EnsembleOutcome(folder, planned=15, done=15, begun=True)
    assert seen == [(done, 15) for done in range(1, 16)]
    ensembles = loaded(folder)
    assert (ensembles.run.count, ensembles.run.size, ensembles.run.state) == (5, Size(), "complete")
    assert [record.key for record in ensembles.records] == [
        ("roll", "ghostball", "null"),
        ("roll", "ghostball", "shots"),
        ("roll", "fake", "shots"),
    ]
    null, ours, fake = (ensembles.members(record) for record in ensembles.records)
    for k in range(5):
        expected = simulate(perturb(roll, Size(), k), record="trajectory")
        times = ensembles.records[0].times
        assert ours.index[k] == k
        assert ours.rest_positions[k].tolist() == expected.rest_positions[:, :2].tolist()
        assert ours.rest_times[k] == expected.rest_time
        assert ours.counts[k].tolist() == [0, 0]
        assert ours.energy[k] == pytest.approx(expected.energy(times).total, rel=1e-12)
        assert null.rest_positions[k].tolist() != ours.rest_positions[k].tolist()
    assert all(map(np.array_equal, ours.parts(), fake.parts()))
    assert ensembles.records[0].times[-1] == simulate(roll).rest_time
    assert ensembles.records[0].load_scene() == roll


def test_neither_jobs_nor_order_change_a_bit(folder: Path, tmp_path: Path, roll: Scene):
    chaos = find_scene("chaos-a")
    run_ensembles([roll, chaos], BOTH, folder, 4)
    first = content(folder)
    assert len(first) == 2 * 3 * 4
    run_ensembles([chaos, roll], BOTH[::-1], folder, 4, jobs=2, reuse=False)
    assert content(folder) == first


def test_a_crash_or_a_missing_end_costs_one_member(roll: Scene, folder: Path):
    labels = ["ghostball", "fake:does=raise", "fake:does=stop"]
    outcome = run_ensembles([roll], labels, folder, 8)
    upward = {str(k) for k in range(8) if perturb(roll, Size(), k).balls[0].velocity[1] > 0.0}
    assert 0 < len(upward) < 8
    assert outcome.failed == len(upward)
    raising, stopping = (loaded(folder).of("roll")[label] for label in labels[1:])
    assert raising.failed == dict.fromkeys(upward, "RuntimeError: lost the balls")
    assert stopping.stopped == dict.fromkeys(upward, "step-limit")
    assert not raising.stopped
    assert not stopping.failed
    ended = loaded(folder).members(raising).index.tolist()
    assert sorted(ended + [int(k) for k in upward]) == list(range(8))


def test_a_process_that_dies_costs_one_member(roll: Scene, folder: Path):
    run_ensembles([roll], ["ghostball", "fake:does=die"], folder, 4, jobs=2)
    record = loaded(folder).of("roll")["fake:does=die"]
    upward = {str(k) for k in range(4) if perturb(roll, Size(), k).balls[0].velocity[1] > 0.0}
    assert record.failed == dict.fromkeys(upward, "the process running it died (exit code 7)")
    assert len(loaded(folder).members(record)) == 4 - len(upward)


def test_an_engine_that_cannot_says_why_and_is_asked_once(roll: Scene, folder: Path):
    asked: list[str] = []
    outcome = run_ensembles(
        [roll],
        ["ghostball", "fake:does=refuse", "absent"],
        folder,
        6,
        progress=lambda _, __, result: asked.append(result.label),
    )
    assert asked.count("fake:does=refuse") == 1
    assert "absent" not in asked
    assert (outcome.done, outcome.failed) == (12 + 6, 0) or outcome.done == outcome.planned
    records = loaded(folder).of("roll")
    assert records["fake:does=refuse"].outcome == "not-representable"
    assert "it slips" in records["fake:does=refuse"].reason
    assert records["absent"].outcome == "unavailable"
    assert "not installed here" in records["absent"].reason


def test_a_scene_that_our_engine_cannot_represent_has_nothing_to_compare(folder: Path):
    # It has air drag on the cloth, and flight without air, not the two together.
    slide = find_scene("sliding-stun")
    air = {"airborne": True, "air_drag": 0.01}
    flight = slide.model_copy(update={"physics": slide.physics.model_copy(update=air)})
    run_ensembles([flight], BOTH, folder, 3)
    ensembles = loaded(folder)
    assert {record.outcome for record in ensembles.records} == {"not-representable"}
    assert all("drag" in record.reason for record in ensembles.records)
    assert compare(ensembles).comparisons == []
    assert compare(ensembles).null.passed is None


# --- taking over


def test_a_larger_ensemble_has_the_members_of_a_smaller_one(folder: Path):
    scene, labels = find_scene("stop"), ["ghostball", "paper-discrete"]
    run_ensembles([scene], labels, folder, 3)
    few = loaded(folder).members(loaded(folder).of("stop")["paper-discrete"])
    outcome = run_ensembles([scene], labels, folder, 5)
    assert (outcome.planned, outcome.taken_over, outcome.done) == (15, 9, 15)
    many = loaded(folder).members(loaded(folder).of("stop")["paper-discrete"])
    assert many.index.tolist() == [0, 1, 2, 3, 4]
    assert all(map(np.array_equal, few.parts(), (part[:3] for part in many.parts())))
    # Fewer again: nothing runs, nothing is lost.
    again = run_ensembles([scene], labels, folder, 2)
    assert again.taken_over == 6
    ensembles = loaded(folder)
    assert len(ensembles.members(ensembles.of("stop")["paper-discrete"])) == 2
    assert run_ensembles([scene], labels, folder, 5).taken_over == 15


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rest_positions", "[[0, 0, 0]]"),
        ("rest_positions", "null"),
        ("energy", "[1, 2]"),
        ("counts", "[1, 2, 3]"),
    ],
)
def test_members_whose_arrays_do_not_fit_are_refused(folder: Path, name: str, value: str):
    """Broken by members of another shape than the ensemble's that are put together with others."""
    run_ensembles([find_scene("stop")], ["ghostball", "paper-discrete"], folder, 2)
    with writing(folder) as database, transaction(database):
        database.execute(
            f"UPDATE records SET record = json_set(record, '$.{name}', json('{value}')) "
            "WHERE kind = 'member' AND json_extract(name, '$[4]') = '1'"
        )
    ensembles = loaded(folder)
    with pytest.raises(ResultsError, match="a perturbed shot is damaged"):
        ensembles.members(ensembles.records[0])


def test_what_changed_or_is_asked_to_runs_again(folder: Path):
    scene, labels = find_scene("stop"), ["ghostball", "paper-discrete"]
    run_ensembles([scene], labels, folder, 2)
    assert run_ensembles([scene], labels, folder, 2, reuse=False).taken_over == 0
    assert run_ensembles([scene], labels, folder, 2, size=Size(velocity=1e-2)).taken_over == 0
    # Of another engine of ours and of the first size: kept all the while.
    other = run_ensembles([scene], ["ghostball", "paper-discrete:dt=0.01"], folder, 2)
    assert other.taken_over == 4
    assert run_ensembles([scene], labels, folder, 2).taken_over == 6
    changed = scene.model_copy(update={"title": "another"})
    assert run_ensembles([changed], labels, folder, 2).taken_over == 0


def test_what_another_package_brings_always_runs(roll: Scene, folder: Path):
    run_ensembles([roll], BOTH, folder, 2)
    assert run_ensembles([roll], BOTH, folder, 2).taken_over == 4  # of ours


def test_failures_run_again(folder: Path, monkeypatch: pytest.MonkeyPatch):
    scene, labels = find_scene("stop"), ["ghostball", "paper-discrete"]
    real = run_module.run_member

    def failing(task):
        return run_module.unended(task, "bad luck") if task.index == 1 else real(task)

    monkeypatch.setattr(run_module, "run_member", failing)
    assert run_ensembles([scene], labels, folder, 3).failed == 3
    monkeypatch.setattr(run_module, "run_member", real)
    again = run_ensembles([scene], labels, folder, 3)
    assert (again.taken_over, again.failed) == (6, 0)


# --- interrupts


def interrupting(after: int):
    left = after

    def progress(*_):
        nonlocal left
        left -= 1
        if left == 0:
            raise KeyboardInterrupt

    return progress


def test_an_interrupt_keeps_what_is_done_and_the_next_run_goes_on(folder: Path):
    scene, labels = find_scene("stop"), ["ghostball", "paper-discrete"]
    outcome = run_ensembles([scene], labels, folder, 4, progress=interrupting(6))
    assert (outcome.interrupted, outcome.done, outcome.begun) == (True, 6, True)
    ensembles = loaded(folder)
    assert ensembles.run.state == "interrupted"
    assert sum(len(ensembles.members(record)) for record in ensembles.records) == 6
    again = run_ensembles([scene], labels, folder, 4)
    assert (again.interrupted, again.taken_over, again.done) == (False, 6, 12)
    assert loaded(folder).run.state == "complete"


def test_an_interrupt_before_the_first_member_leaves_the_folder_as_it_was(
    roll: Scene, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    run_ensembles([roll], BOTH, folder, 2)
    before, members = loaded(folder).run.run, content(folder)

    def interrupted(task):
        raise KeyboardInterrupt

    monkeypatch.setattr(run_module, "run_member", interrupted)
    outcome = run_ensembles([find_scene("stop")], BOTH, folder, 2)
    assert (outcome.interrupted, outcome.begun) == (True, False)
    assert (loaded(folder).run.run, content(folder)) == (before, members)


def test_each_member_is_kept_before_it_is_told(roll: Scene, folder: Path):
    states = []

    def look(*_):
        ensembles = loaded(folder)
        done = sum(len(ensembles.members(record)) for record in ensembles.records)
        states.append((ensembles.run.state, done))

    run_ensembles([roll], BOTH, folder, 3, progress=look)
    assert states == [("running", done) for done in range(1, 10)]


# --- refused


@pytest.mark.parametrize(
    ("labels", "count", "said"),
    [
        (BOTH, 1, "must have 2 to 1000 members, got 1"),
        (BOTH, 1_000_000, "must have 2 to 1000 members, got 1000000"),
        (["ghostball"], 5, "there must be that one and another, got ghostball"),
        (["fake", "absent"], 5, "compare engines with `ghostball`"),
        ([], 5, "got none"),
        (["ghostball", "fake", "fake"], 5, "each engine must be given once, got fake again"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_anything_runs(
    roll: Scene, folder: Path, labels, count, said
):
    for attempt in (run_ensembles, check_ensembles):
        with pytest.raises(EnsembleError) as refused:
            attempt([roll], labels, folder, count)
        assert said in str(refused.value)
    assert Ensembles.load(folder) is None


def test_other_wrong_input_is_refused(roll: Scene, folder: Path, tmp_path: Path):
    with pytest.raises(EnsembleError, match="at least one scene"):
        run_ensembles([], BOTH, folder, 2)
    with pytest.raises(EnsembleError, match="each scene must be given once, got roll again"):
        run_ensembles([roll, roll], BOTH, folder, 2)
    with pytest.raises(EnsembleError, match="`jobs` must be at least 1, got 0"):
        run_ensembles([roll], BOTH, folder, 2, jobs=0)
    with pytest.raises(EnsembleError, match="balls could change places"):
        check_ensembles([roll], BOTH, folder, 2, Size(position=0.02))
    with pytest.raises(GhostballError, match="engine must be an installed one"):
        run_ensembles([roll], ["ghostball", "unheard-of"], folder, 2)
    with pytest.raises(ResultsError, match="not a results folder yet"):
        run_ensembles([roll], BOTH, tmp_path / "empty", 2)
    assert not (tmp_path / "empty").exists()


def test_damaged_ensembles_are_refused_before_anything_runs(roll: Scene, folder: Path):
    run_ensembles([roll], BOTH, folder, 2)
    with writing(folder) as database, transaction(database):
        database.execute(
            "UPDATE documents SET content = json_set(content, '$.ensembles[0].times', 'soon') "
            "WHERE name = 'ensembles'"
        )
    before = content(folder)
    for attempt in (run_ensembles, check_ensembles):
        with pytest.raises(ResultsError) as refused:
            attempt([roll], BOTH, folder, 2)
        assert "what its ensembles are of is damaged: `ensembles.0.times`" in str(refused.value)
        assert "Move the file away, or choose another `--out`" in str(refused.value)
    assert content(folder) == before
