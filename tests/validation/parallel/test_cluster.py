"""Tasks on a Dask cluster have the same answers as on one machine, even if processes crash."""

from __future__ import annotations

import os
import signal
import socket
import time
from contextlib import closing, suppress
from pathlib import Path

import pytest

import ghostball.validation.parallel.cluster
from ghostball.validation.parallel.cluster import (
    ClusterError,
    ClusterLostError,
    cluster_at,
    code_here,
)
from ghostball.validation.parallel.pool import limit_of, run_tasks

pytest.importorskip("distributed", reason="needs Dask: pip install '.[cluster]'")

from dask_cluster import dask_cluster
from pool_tasks import crashed, work

LIMIT = limit_of(60.0)


def pids(path: Path) -> list[list[int]]:
    """Return the worker and the process of each start of the task."""
    if not path.exists():
        return []
    return [list(map(int, line.split())) for line in path.read_text().splitlines()]


def until(true, seconds: float = 30.0) -> None:
    """Wait until `true()` is true; fail after `seconds` [s]."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def is_running(pid: int) -> bool:
    """Return whether a process exists and hasn't ended."""
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
    tasks = ["a", "crash 0", "crash 7", "raise no luck", "print hello", "sleep 600", "b"]

    def limit(task: str) -> float:
        return 1.0 if task == "sleep 600" else 60.0

    def found(jobs) -> tuple[set[str], dict[str, str]]:
        with closing(run_tasks(tasks, jobs, work, limit)) as answers:
            got = list(answers)
        assert len(got) == len(tasks)
        heard = {done.task: done.printed for done in got if done.printed}
        return {done.or_else(crashed) for done in got}, heard

    with cluster_at(cluster.address) as there:
        answers, heard = found(there)
    assert (answers, heard) == found(2)
    assert heard["print hello"] == "hello"


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
        until(lambda: not is_running(process))  # the process ends with its worker
    assert sorted(got) == sorted(f"done {task}" for task in tasks)
    assert len({worker for worker, _ in pids(note)}) == 2  # another worker repeated the task


@pytest.mark.slow
def test_workers_with_other_code_are_refused(cluster, monkeypatch):
    theirs = code_here()
    sources = theirs["ghostball's sources"]
    ours = {"ghostball's sources": "0123456789ab", "numpy": "1.0"}
    monkeypatch.setattr(ghostball.validation.parallel.cluster, "code_here", lambda: theirs | ours)
    with cluster_at(cluster.address) as there, pytest.raises(ClusterError) as refused:
        list(run_tasks(["a", "b"], there, work))
    assert not isinstance(refused.value, ClusterLostError)
    assert str(refused.value) == (
        f"a worker of the cluster at {cluster.address} has a different version of the code: "
        f"ghostball's sources is {sources} there and 0123456789ab here, numpy is {theirs['numpy']} "
        "there and 1.0 here. Install the same version there"
    )


ENGINE = "engine_of_cluster:simulate"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theirs", "said"),
    [
        (None, f"is missing (engine `{ENGINE}` can't be imported: ModuleNotFoundError"),
        ("def simulate(scene, dt=0.5): ...", " there and "),
        ("import no_such_thing\ndef simulate(scene): ...", "No module named 'no_such_thing'"),
    ],
    ids=["lacks it", "another version", "can't import it"],
)
def test_workers_with_another_engine_are_refused(tmp_path, monkeypatch, theirs, said):
    # Otherwise the verdict would be about the worker's version of the engine.
    ours, others = tmp_path / "ours", tmp_path / "theirs"
    for folder, text in ((ours, "def simulate(scene): ..."), (others, theirs)):
        folder.mkdir()
        if text is not None:
            (folder / "engine_of_cluster.py").write_text(text)
    with monkeypatch.context() as there:
        there.setenv("PYTHONPATH", str(others))
        cluster = dask_cluster(tmp_path, workers=1)
        address = cluster.__enter__().address
    monkeypatch.syspath_prepend(str(ours))
    try:
        with cluster_at(address) as connected:
            assert [one.given for one in run_tasks(["a"], connected, work)] == ["done a"]
            with pytest.raises(ClusterError) as refused:
                list(run_tasks(["a"], connected, work, kind=lambda _: ENGINE))
    finally:
        cluster.__exit__(None, None, None)
    assert not isinstance(refused.value, ClusterLostError)
    assert f"the source of engine `{ENGINE}` is" in str(refused.value)
    assert said in str(refused.value)


@pytest.mark.slow
def test_a_scheduler_that_is_killed_is_said(tmp_path):
    note = tmp_path / "note"
    with dask_cluster(tmp_path) as cluster, cluster_at(cluster.address) as there:
        answers = run_tasks([f"note {note}", *"abcdef"], there, work, LIMIT)
        next(answers)
        cluster.scheduler.kill()
        with pytest.raises(ClusterLostError, match="run the same command to continue"):
            list(answers)
