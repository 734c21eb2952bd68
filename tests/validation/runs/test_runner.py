"""The runner reuses tasks with a known key, runs all other tasks, and stores each when it ends."""

from __future__ import annotations

import multiprocessing

from pool_tasks import crashed, work
from pydantic import TypeAdapter

from ghostball.validation.parallel.pool import limit_of
from ghostball.validation.results.record_store import RecordStore
from ghostball.validation.runs.runner import run


class Notes(RecordStore):
    """Records that consist of a task and its outcome."""

    kind = "finding"
    adapter = TypeAdapter(tuple[str, str])
    what = "a note"

    def name_of(self, record):
        return (record[0],)

    def is_repeatable(self, record):
        return record[1].startswith("done")


def ran(folder, keys, code="code", **options):
    return run(
        {(task,): key for task, key in keys.items()},
        lambda names: (name[0] for name in names),
        work,
        lambda done: (done.task, done.or_else(crashed)),
        Notes(folder, code),
        **options,
    )


def stored(folder):
    return sorted(Notes(folder).current().values())


def test_what_has_the_same_key_is_reused_and_all_else_is_done(tmp_path):
    seen, announced = [], []
    first = ran(tmp_path, {"a": "1", "b": "2", "c": ""})
    assert (first.reused, first.interrupted, first.begun) == (0, False, True)
    again = ran(
        tmp_path,
        {"b": "other", "a": "1", "c": "", "d": "4"},
        announce=announced.append,
        progress=lambda *one: seen.append(one),
    )
    assert again.reused == 1
    assert [list(one.records) for one in announced] == [[("a",)]]
    assert [(done, planned, record[0]) for done, planned, record in seen] == [
        (2, 4, "b"),
        (3, 4, "c"),
        (4, 4, "d"),
    ]
    assert stored(tmp_path) == [(task, f"done {task}") for task in "abcd"]


def test_other_code_and_who_asks_for_it_do_all_again(tmp_path):
    keys = {"a": "1"}
    ran(tmp_path, keys)
    announced = []
    assert ran(tmp_path, keys, code="edited", announce=announced.append).reused == 0
    assert announced[0].why == "the code or the environment changed"
    assert ran(tmp_path, keys, code="edited", reuse=False).reused == 0
    assert ran(tmp_path, keys, code="edited").reused == 1
    for _ in range(2):
        assert ran(tmp_path, keys, code="").reused == 0


def test_a_process_that_crashes_costs_its_task_which_is_done_again(tmp_path):
    keys = {"crash 3": "1", "a": "2"}
    for reused in (0, 1):
        outcome = ran(tmp_path, keys, jobs=2, limit=limit_of(60.0))
        assert outcome.reused == reused
        assert sorted(outcome.records.values()) == [
            ("a", "done a"),
            ("crash 3", "crash 3: its process crashed (exit code 3)"),
        ]
    assert multiprocessing.active_children() == []


def test_an_interrupt_keeps_what_is_done_and_the_next_run_continues(tmp_path):
    def interrupt(done, planned, last):
        if done == 2:
            raise KeyboardInterrupt

    keys = dict(zip("abc", "123", strict=True))
    outcome = ran(tmp_path, keys, progress=interrupt)
    assert outcome.interrupted
    assert list(outcome.records) == [("a",), ("b",)]
    assert ran(tmp_path, keys).reused == 2


def test_an_interrupt_before_the_first_is_done_leaves_all_as_it_was(tmp_path):
    def interrupt(names):
        raise KeyboardInterrupt

    ran(tmp_path, {"a": "1"})
    outcome = ran(tmp_path, {"b": "2"}, prepare=interrupt)
    assert (outcome.interrupted, outcome.begun, outcome.records) == (True, False, {})
    assert stored(tmp_path) == [("a", "done a")]


def test_a_run_of_a_part_keeps_the_rest_for_a_later_one(tmp_path):
    ran(tmp_path, {"a": "1", "b": "2"})
    ran(tmp_path, {"a": "1"})
    assert stored(tmp_path) == [("a", "done a")]
    assert ran(tmp_path, {"a": "1", "b": "2"}).reused == 2
