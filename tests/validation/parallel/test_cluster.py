"""Tasks on a Dask cluster: the same answers as on one machine, whatever dies on the way."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing, suppress
from itertools import count
from pathlib import Path

import pytest

import ghostball.validation.parallel.cluster
from ghostball.validation.parallel.cluster import (
    ClusterError,
    ClusterLostError,
    cluster_at,
    versions,
)
from ghostball.validation.parallel.pool import limit_of, run_tasks

pytest.importorskip("distributed", reason="needs Dask: pip install 'ghostball[cluster]'")

from dask_cluster import dask_cluster, kill_group
from pool_tasks import died, work

LIMIT = limit_of(60.0)


def pids(path: Path) -> list[list[int]]:
    """Return worker and process of each time that a task was begun."""
    if not path.exists():
        return []
    return [list(map(int, line.split())) for line in path.read_text().splitlines()]


def until(true, seconds: float = 30.0) -> None:
    """Wait until something is so."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def is_running(pid: int) -> bool:
    """Whether a process is there that hasn't ended."""
    with suppress(FileNotFoundError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("dask")) as cluster:
        yield cluster


@pytest.mark.parametrize("address", ["nowhere", "foo://a:1", "tcp://127.0.0.1:port", ""])
def test_what_is_no_address_is_refused_at_once(address):
    with (
        pytest.raises(ClusterError, match="no Dask scheduler can be reached at"),
        cluster_at(address),
    ):
        pass


def test_without_an_address_there_is_no_cluster():
    with cluster_at(None) as none:
        assert none is None


def test_an_address_where_nothing_answers_as_it_should_is_refused(monkeypatch):
    monkeypatch.setattr(ghostball.validation.parallel.cluster, "CONNECT_LIMIT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(ClusterError, match=r"no answer within 0\.5 s"), cluster_at(address):
            pass


@pytest.mark.slow
def test_what_each_task_comes_to_is_as_on_one_machine(cluster):
    tasks = ["a", "die 0", "die 7", "raise no luck", "print hello", "sleep 600", "b"]

    def limit(task: str) -> float:
        return 1.0 if task == "sleep 600" else 60.0

    def found(jobs) -> tuple[set[str], dict[str, str]]:
        with closing(run_tasks(tasks, jobs, work, limit)) as answers:
            got = list(answers)
        assert len(got) == len(tasks)
        heard = {done.task: done.printed for done in got if done.printed}
        return {done.or_else(died) for done in got}, heard

    with cluster_at(cluster.address) as there:
        answers, heard = found(there)
    assert (answers, heard) == found(2)
    assert heard["print hello"] == "hello"


@pytest.mark.slow
def test_tasks_are_taken_as_workers_become_free(cluster):
    taken: list[int] = []

    def endless():
        for number in count():
            taken.append(number)
            yield f"{number}"

    with (
        cluster_at(cluster.address) as there,
        closing(run_tasks(endless(), there, work)) as answers,
    ):
        for number in range(5):
            next(answers)
            assert len(taken) <= number + 3  # those done, and one for each of two workers


@pytest.mark.slow
def test_closing_ends_what_the_workers_do(cluster, tmp_path):
    note = tmp_path / "note"
    with cluster_at(cluster.address) as there:
        answers = run_tasks(["a", f"note {note}"], there, work)
        assert next(answers).given == "done a"
        until(lambda: pids(note))
        answers.close()
    until(lambda: not is_running(pids(note)[0][1]))


@pytest.mark.slow
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_ends_early_leaves_nothing_at_work(cluster, tmp_path, sign):
    note, script = tmp_path / "note", tmp_path / "run.py"
    script.write_text(RUN)
    path = os.pathsep.join(filter(None, sys.path))
    with subprocess.Popen(
        [sys.executable, str(script), cluster.address, f"note {note}"],
        env=os.environ | {"PYTHONPATH": path},
        stderr=subprocess.PIPE,
    ) as run:
        until(lambda: pids(note))
        run.send_signal(sign)
        _, errors = run.communicate(timeout=30.0)
    assert run.returncode == -sign
    assert errors.decode().endswith("KeyboardInterrupt\n" if sign == signal.SIGINT else "")
    until(lambda: not is_running(pids(note)[0][1]))


RUN = """
import sys
from pool_tasks import work
from ghostball.validation.parallel.cluster import cluster_at
from ghostball.validation.parallel.pool import run_tasks

if __name__ == "__main__":
    with cluster_at(sys.argv[1]) as there:
        list(run_tasks(sys.argv[2:], there, work))
"""


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_nothing(tmp_path):
    note = tmp_path / "note"
    tasks = [f"note {note}", *"abcdef"]
    with dask_cluster(tmp_path) as cluster, cluster_at(cluster.address) as there:
        answers = (done.given for done in run_tasks(tasks, there, work, LIMIT))
        got = [next(answers)]
        until(lambda: pids(note))
        ((worker, process),) = pids(note)
        os.kill(worker, signal.SIGKILL)
        got += answers
        until(lambda: not is_running(process))  # it ends with its worker
    assert sorted(got) == sorted(f"done {task}" for task in tasks)
    assert len({worker for worker, _ in pids(note)}) == 2  # another one did it again


@pytest.mark.slow
def test_a_task_that_kills_its_workers_has_crashed(tmp_path):
    # With nannies, as workers have unless told otherwise: they start a worker again.
    with dask_cluster(
        tmp_path, workers=0, DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="1"
    ) as cluster:
        nanny = cluster.add_worker("--nanny")
        with cluster_at(cluster.address) as there:
            tasks = run_tasks(["a", "kill", "b"], there, work, LIMIT)
            found = [done.or_else(died) for done in tasks]
        nanny.terminate()
        nanny.wait(6.0)  # it would kill a worker that waited for a process of ours after 8 s
    assert sorted(found) == [
        "done a",
        "done b",
        "kill: it ended 2 workers of the cluster, one by one",
    ]


@pytest.mark.slow
def test_a_cluster_without_workers_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(ghostball.validation.parallel.cluster, "PATIENCE", 1.0)
    with (
        dask_cluster(tmp_path, workers=0) as cluster,
        cluster_at(cluster.address) as there,
        pytest.raises(ClusterLostError, match="it has had no worker for 1 s"),
    ):
        list(run_tasks(["a"], there, work))


@pytest.mark.slow
def test_workers_with_other_code_are_refused(cluster, monkeypatch):
    theirs = versions()
    sources = theirs["ghostball's sources"]
    ours = {"ghostball's sources": "0123456789ab", "numpy": "1.0"}
    monkeypatch.setattr(ghostball.validation.parallel.cluster, "versions", lambda: theirs | ours)
    with cluster_at(cluster.address) as there, pytest.raises(ClusterError) as refused:
        list(run_tasks(["a", "b"], there, work))
    assert not isinstance(refused.value, ClusterLostError)
    assert str(refused.value) == (
        f"a worker of the cluster at {cluster.address} has other code: ghostball's sources is "
        f"{sources} there and 0123456789ab here, numpy is {theirs['numpy']} "
        "there and 1.0 here. Install the same there"
    )


@pytest.mark.slow
def test_workers_without_ghostball_are_refused(tmp_path):
    # The scheduler lacks it too, and does well without.
    lacks = tmp_path / "lacks"
    lacks.mkdir()
    (lacks / "ghostball.py").write_text("raise ImportError('no ghostball')")
    with (
        dask_cluster(tmp_path, workers=0, PYTHONPATH=str(lacks)) as cluster,
        cluster_at(cluster.address) as there,
    ):
        lacking = cluster.add_worker("--no-nanny", PYTHONPATH=str(lacks))
        with pytest.raises(ClusterError, match=r"ImportError: no ghostball\. Install the same"):
            list(run_tasks(["a"], there, work))
        kill_group(lacking)
        cluster.add_worker("--no-nanny")
        assert [done.given for done in run_tasks(["a"], there, work)] == ["done a"]
