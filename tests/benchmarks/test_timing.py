"""Fails where tasks don't take turns, an interrupt loses values, or progress miscounts."""

import pytest

from benchmarks.timing import Figures, Spread, Task, take_turns


def task_of(name, log, most=None, interrupt_at=None):
    def sample(clock):
        log.append(name)
        if interrupt_at is not None and log.count(name) == interrupt_at:
            raise KeyboardInterrupt
        return {"seconds": clock()}

    def prepare():
        log.append(f"prepare {name}")
        return sample

    return Task(name, prepare, most)


def ticking():
    seconds = iter(range(1000))
    return lambda: float(next(seconds))


def test_tasks_take_turns_and_are_prepared_once():
    log = []
    take_turns([task_of("a", log), task_of("b", log)], 2)
    assert log == ["prepare a", "a", "prepare b", "b", "a", "b"]


@pytest.mark.parametrize(
    ("most", "rounds", "due"),
    [(None, 3, [0, 1, 2]), (1, 4, [3]), (2, 4, [1, 3]), (3, 7, [2, 4, 6]), (9, 2, [0, 1])],
)
def test_a_slow_task_is_sampled_less_often_and_over_all_rounds(most, rounds, due):
    task = Task("slow", lambda: lambda _: {}, most)
    assert [turn for turn in range(rounds) if task.due(turn, rounds)] == due


def test_the_clock_is_handed_on_and_all_values_kept():
    samples = take_turns([task_of("a", [])], 3, clock=ticking())
    assert samples.values == {"a": {"seconds": [0.0, 1.0, 2.0]}}
    assert samples.spreads("a") == {"seconds": Spread(1.0, 0.0, 2.0, 3)}


def test_an_interrupt_keeps_what_was_measured():
    samples = take_turns([task_of("a", []), task_of("b", [], interrupt_at=2)], 5, clock=ticking())
    assert samples.interrupted
    assert [len(samples.values[name]["seconds"]) for name in ("a", "b")] == [2, 1]


@pytest.mark.parametrize(("count", "p99"), [(1, 1.0), (99, 99.0), (100, 99.0), (1000, 990.0)])
def test_the_99th_percentile_is_exceeded_by_1_percent_at_most(count, p99):
    figures = Figures.of([float(value) for value in range(count, 0, -1)])
    middle = (count + 1) / 2.0
    assert figures == Figures(median=middle, mean=middle, p99=p99, slowest=float(count))
