"""The timer takes turns, and prepares each task once."""

import pytest

from ghostball.validation.runs.interleave import Task, interleave


def task_of(name, log, most=None):
    def sample():
        log.append(name)
        return {"seconds": float(len(log))}

    def prepare():
        log.append(f"prepare {name}")
        return sample

    return Task(name, prepare, most)


def test_tasks_are_interleaved_prepared_once_and_all_values_kept():
    log, seen = [], []
    found = interleave([task_of("a", log), task_of("b", log)], 2, lambda *done: seen.append(done))
    assert log == ["prepare a", "a", "prepare b", "b", "a", "b"]
    assert found == {"a": {"seconds": [2.0, 5.0]}, "b": {"seconds": [4.0, 6.0]}}
    assert seen == [(1, 4, "a"), (2, 4, "b"), (3, 4, "a"), (4, 4, "b")]


@pytest.mark.parametrize(
    ("most", "rounds", "due"),
    [(None, 3, [0, 1, 2]), (1, 4, [3]), (2, 4, [1, 3]), (3, 7, [2, 4, 6]), (9, 2, [0, 1])],
)
def test_a_slow_task_is_sampled_less_often_and_over_all_rounds(most, rounds, due):
    task = Task("slow", lambda: lambda: {}, most)
    assert [turn for turn in range(rounds) if task.due(turn, rounds)] == due
