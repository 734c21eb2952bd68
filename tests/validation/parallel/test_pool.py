"""Work in processes: a crash or a hang affects only its task, and no process is left running."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from itertools import count
from pathlib import Path

import pytest
from named_pipes import read_to_end
from pool_tasks import crashed, never, say, wait_a_second, work

from ghostball.validation.parallel.pool import Done, limit_of, run_tasks

LIMIT = limit_of(30.0)


def results(tasks, jobs=1, limit=LIMIT, prepare=None) -> list[str]:
    with closing(run_tasks(tasks, jobs, work, limit, prepare)) as found:
        got = [done.or_else(crashed) for done in found]
    assert multiprocessing.active_children() == []
    return got


def test_without_a_limit_one_job_is_this_process():
    (done,) = run_tasks(["pid"], 1, lambda _: os.getpid())
    assert done == Done("pid", os.getpid(), "", "")


def test_with_a_limit_one_job_is_another_process_and_a_crash_costs_its_task():
    assert results(["crash 7", "a", "crash 3", "b"]) == [
        "crash 7: its process crashed (exit code 7)",
        "done a",
        "crash 3: its process crashed (exit code 3)",
        "done b",
    ]


def test_a_process_that_ends_as_if_all_were_well_has_crashed_too():
    # Without a time limit, nothing else would end the wait.
    found = results(["crash 0", "a", "b"], jobs=2, limit=None)
    assert sorted(found) == [
        "crash 0: its process crashed (exit code 0)",
        "done a",
        "done b",
    ]


def test_what_raises_costs_its_task_and_says_where():
    raised, after = run_tasks(["raise no luck", "a"], 1, work, LIMIT)
    assert (raised.crashed, raised.given) == ("its process crashed (exit code 1)", None)
    assert raised.printed.endswith("ValueError: no luck")
    assert "in work" in raised.printed
    assert after.given == "done a"


def test_tasks_are_taken_as_processes_become_free():
    taken: list[int] = []

    def endless():
        for number in count():
            taken.append(number)
            yield f"{number}"

    with closing(run_tasks(endless(), 2, work)) as found:
        for number in range(5):
            next(found)
            assert len(taken) <= number + 2 + 1  # finished tasks, tasks in both processes, this one


def test_a_hang_is_ended_and_a_task_may_have_a_limit_of_its_own():
    def limit(task: str) -> float:
        return 0.3 if task == "sleep 600" else 60.0

    assert results(["sleep 600", "sleep 0.5"], limit=limit) == [
        "sleep 600: it exceeded the time limit of 0.3 s",
        "done sleep 0.5",
    ]


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
@pytest.mark.parametrize("task", ["native", "deaf"])
def test_one_that_lets_no_handler_run_or_ignores_its_end_is_ended_at_once(task):
    found = results([task, "a"], limit=lambda one: 0.3 if one == task else 60.0)
    assert found == [f"{task}: it exceeded the time limit of 0.3 s", "done a"]


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
def test_a_process_that_crashes_while_idle_costs_no_task():
    # Fails if the next task is blamed for a crash that an earlier task caused.
    def tasks():
        yield "later"
        time.sleep(0.5)  # until the process has crashed
        yield "a"

    assert results(tasks()) == ["done later", "done a"]


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
def test_a_process_that_crashes_in_the_midst_of_its_answer_costs_its_task():
    # Fails if an incomplete message ends the whole run with an OSError.
    found = results(["half", "a"])
    assert found == ["half: its process crashed (exit code 3)", "done a"]


@pytest.mark.skipif(os.name == "nt", reason="process groups are POSIX")
@pytest.mark.parametrize("child", ["program", "fork"])
@pytest.mark.parametrize(
    ("then", "outcome"),
    [
        ("sleep 600", "it exceeded the time limit of 2 s"),
        ("crash 7", "its process crashed (exit code 7)"),
        ("a", ""),
    ],
)
def test_what_a_task_started_ends_with_its_process(tmp_path, child, then, outcome):
    # Without a process group, a started program would continue, and keep our output open.
    os.mkfifo(tmp_path / "pipe")
    with (
        closing(run_tasks([f"start {child} {tmp_path / 'pipe'} {then}"], 1, work, 2.0)) as found,
        ThreadPoolExecutor(1) as thread,
    ):
        pipe = thread.submit((tmp_path / "pipe").open, "rb")
        (done,) = found
    assert done.crashed == outcome
    with pipe.result() as file:
        assert read_to_end(file) == b"there\n"  # the pipe ends when no process holds it


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks are POSIX")
@pytest.mark.parametrize("limit", [LIMIT, None], ids=["other process", "this process"])
def test_a_child_that_returns_ends_and_its_parent_answers(limit):
    # Otherwise both would answer through one pipe, or both would continue as the harness.
    with closing(run_tasks(["fork 0.5", "a"], 1, work, limit)) as found:
        assert [(done.given, done.crashed) for done in found] == [
            ("done fork 0.5", ""),
            ("done a", ""),
        ]


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
def test_an_answer_that_cannot_be_read_costs_its_task():
    first, after = results(["garbage", "a"])
    assert first.startswith("garbage: its process returned an answer that can't be read (")
    assert after == "done a"


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
def test_an_answer_without_an_end_is_given_up_in_time():
    # The wait for the rest of an answer must have a limit.
    found = results(["header", "a"], limit=lambda one: 0.5 if one == "header" else 60.0)
    said = "header: it exceeded the time limit of 0.5 s while it returned its answer"
    assert found == [said, "done a"]


def test_a_process_does_tasks_of_one_kind_only():
    # Fails if a patched function of one engine affects another engine.
    tasks = ["pid a", "pid b", "pid a", "pid b", "pid a"]
    with closing(run_tasks(tasks, 1, work, LIMIT, kind=lambda task: task[-1])) as found:
        first, other, *rest = [done.given for done in found]
    assert first != other
    assert rest == [first, other, first]


def test_a_process_that_cannot_start_costs_a_task_each():
    assert results(["a", "b"], prepare=never) == [
        "a: its process crashed (exit code 5)",
        "b: its process crashed (exit code 5)",
    ]


def test_a_task_and_an_answer_of_many_megabytes_pass():
    # Fails if both sides wait for the other side to read.
    long = "a" * 30_000_000
    assert results([long, long], jobs=2) == [f"done {long}"] * 2


def test_closing_ends_what_runs():
    running = run_tasks(["a", "sleep 600", "b"], 1, work, LIMIT)
    assert next(running).given == "done a"
    running.close()
    assert multiprocessing.active_children() == []


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
@pytest.mark.parametrize(
    "task",
    [
        "time.sleep(0.0)",
        "time.sleep(1.0)",
        "time.sleep(600.0)",
        "subprocess.run(['sleep', '600'], stdout=kept)",
        pytest.param(
            "sum(range(10**13))",
            marks=pytest.mark.skipif(sys.platform != "linux", reason="asks the system for it"),
        ),
    ],
    ids=["idle", "answers", "hangs", "hangs in a program", "hangs in native code"],
)
def test_a_worker_whose_parent_is_killed_ends(tmp_path, task):
    script, said = tmp_path / "parent.py", tmp_path / "said"
    script.write_text(PARENT)
    os.mkfifo(said)
    with (
        subprocess.Popen(
            [sys.executable, str(script), str(said), task],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        ) as parent,
        said.open("rb") as worker,
    ):
        assert worker.readline() == b"at work\n"
        parent.kill()
        assert parent.communicate(timeout=60.0) == (b"", b"")
        assert read_to_end(worker) == b""  # the pipe ends with the worker


PARENT = """
import subprocess, sys, time
from ghostball.validation.parallel.pool import limit_of, run_tasks


def work(task):
    said, what = task
    global kept
    kept = open(said, "w")
    print("at work", file=kept, flush=True)
    exec(what)


if __name__ == "__main__":
    list(run_tasks([(sys.argv[1], sys.argv[2])], 1, work, limit_of(900.0)))
    time.sleep(600)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals to a process group are POSIX")
def test_ctrl_c_in_a_terminal_is_for_the_parent_alone(tmp_path):
    # A terminal signals the whole process group, but only the parent may react.
    script, said = tmp_path / "parent.py", tmp_path / "said"
    script.write_text(INTERRUPTED)
    os.mkfifo(said)
    with (
        subprocess.Popen(
            [sys.executable, str(script), str(said)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            start_new_session=True,
        ) as parent,
        said.open("rb") as workers,
    ):
        assert [workers.readline() for _ in range(2)] == [b"at work\n"] * 2
        os.killpg(parent.pid, signal.SIGINT)
        try:
            rest, errors = parent.communicate(timeout=60.0)
        except subprocess.TimeoutExpired:
            os.killpg(parent.pid, signal.SIGKILL)  # so that the test doesn't wait for the tasks
            raise
        assert read_to_end(workers) == b""  # the pipe ends with the workers
    assert (rest, errors) == (b"interrupted\n", b"")
    assert parent.returncode == 130


INTERRUPTED = """
import sys, time
from ghostball.validation.parallel import pool
from ghostball.validation.parallel.pool import run_tasks


def work(said):
    with open(said, "w") as file:
        print("at work", file=file, flush=True)
        time.sleep(600.0)


def kill_late(process):  # so that a worker that answers has the time to say so
    time.sleep(0.3)
    kill(process)


if __name__ == "__main__":
    kill, pool.Process.kill = pool.Process.kill, kill_late
    try:
        list(run_tasks(sys.argv[1:] * 2, 2, work))
    except KeyboardInterrupt:
        print("interrupted", flush=True)
        raise SystemExit(130)
"""


@pytest.mark.parametrize("limit", [LIMIT, None], ids=["other process", "this process"])
def test_what_a_task_prints_is_kept_with_it_and_goes_nowhere_else(capfd, limit):
    tasks = ["a", "b", "crash 3", "c"] if limit else ["a", "b"]
    with closing(run_tasks(tasks, 1, say, limit)) as found:
        heard = [(done.task, done.printed) for done in found]
    assert [task for task, _ in heard] == tasks  # with the output of the crashed task
    for task, text in heard:
        assert text.splitlines()[0] == f"said {task}"
        assert ("and more" in text) is (limit is not None)
    seen = capfd.readouterr()
    assert seen.out == ""
    assert ("and more" in seen.err) is (limit is None)  # stderr may also carry our messages


def test_what_a_process_does_first_is_in_no_limit_of_a_task():
    assert results(["a"], limit=limit_of(0.5), prepare=wait_a_second) == ["done a"]
