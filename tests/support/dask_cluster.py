"""A Dask cluster of processes on this machine, which tests may kill."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

PATIENCE = 60.0
"""Time limit for the start and the end of a scheduler or a worker [s]."""


class DaskCluster:
    """A scheduler and workers, each a process and the leader of its group.

    Attributes
    ----------
    address : str
        Address of the scheduler.
    scheduler, workers : Popen
    """

    def __init__(self, folder: Path, ending: ExitStack, **variables: str) -> None:
        self._folder, self._ending = folder, ending
        self.workers: list[subprocess.Popen[bytes]] = []
        given = ("--host", "127.0.0.1", "--port", "0")
        self.scheduler = self._start("scheduler", *given, **variables)
        self.address = self._said("Scheduler at:").split()[-1]

    def add_worker(self, *options: str, **variables: str) -> subprocess.Popen[bytes]:
        """Start a worker with one thread, and return it when the scheduler has registered it."""
        given = ("--nthreads", "1", "--host", "127.0.0.1", "--local-directory", str(self._folder))
        self.workers.append(self._start("worker", self.address, *given, *options, **variables))
        self._said("Registered to:")
        return self.workers[-1]

    def _start(self, kind: str, *options: str, **variables: str) -> subprocess.Popen[bytes]:
        self._log = self._folder / f"{kind}-{len(self.workers)}.log"
        path = os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), *sys.path]))
        with self._log.open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--no-dashboard", *options],
                stdout=log,
                stderr=log,
                env=os.environ | {"PYTHONPATH": path} | variables,
                cwd=self._folder,
                start_new_session=True,
            )
        self._ending.callback(kill_group, process)
        return process

    def _said(self, what: str) -> str:
        """Wait until the process started last prints a line with `what`, and return the line."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            for line in self._log.read_text().splitlines():
                if what in line:
                    return line
            time.sleep(0.05)
        raise AssertionError(self._log.read_text())


def kill_group(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and its children, unless it has ended."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@contextmanager
def dask_cluster(folder: Path, workers: int = 2, **variables: str) -> Iterator[DaskCluster]:
    """Yield a cluster that ends with the block; workers that end aren't started again.

    `variables`: environment variables of the scheduler.
    """
    with ExitStack() as ending:
        cluster = DaskCluster(folder, ending, **variables)
        for _ in range(workers):
            cluster.add_worker("--no-nanny")
        yield cluster
