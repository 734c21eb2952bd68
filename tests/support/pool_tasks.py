"""Tasks of other processes in tests of the pool and of the report.

The processes import this module by its name. A module of `tests` might not be found, because some
packages install a package `tests`.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path


def work(task: str) -> str:
    """Perform a task, given as a word and its arguments."""
    word, _, rest = task.partition(" ")
    if word == "crash":
        os._exit(int(rest))
    if word == "sleep":
        time.sleep(float(rest))
    if word == "native":  # code during which no signal handler runs
        sum(range(10**13))
    if word == "deaf":
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(600.0)
    if word == "later":  # crash when idle
        signal.signal(signal.SIGALRM, lambda *_: os._exit(9))
        signal.setitimer(signal.ITIMER_REAL, 0.05)
    if word == "pid":
        return f"{os.getpid()}"
    if word == "raise":
        raise ValueError(rest)
    if word == "print":
        print(rest)
    if word == "kill":  # the parent, such as a worker of a cluster
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(600.0)
    if word == "note":  # write the process ids; take 600 s the first time
        with open(rest, "a") as file:
            file.write(f"{os.getppid()} {os.getpid()}\n")
        time.sleep(0.5 if len(Path(rest).read_text().splitlines()) > 1 else 600.0)
    if word == "start":  # start a child that holds a pipe open, then do the rest
        child, path, then = rest.split(" ", 2)
        start_child(child, path)
        work(then)
    if word == "fork":  # fork, and return in both processes
        if os.fork() == 0:
            return "done by a child"
        time.sleep(float(rest))
    if word == "garbage":
        os.write(_answers(), b"\x00\x00\x00\x04junk")
    if word == "header":  # start an answer that never ends
        os.write(_answers(), b"\x7f\xff\xff\xff")
    if word == "half":  # be killed in the middle of the answer
        os.write(_answers(), b"\x00\x00\x10\x00half")
        os._exit(3)
    return f"done {task}"


def start_child(kind: str, path: str) -> None:
    """Start a process that holds an end of a pipe open and doesn't exit."""
    with open(path, "w") as pipe:  # waits for a reader
        pipe.write("there\n")
        pipe.flush()
        if kind == "program":
            subprocess.Popen(["sleep", "600"], stdout=pipe)
        elif os.fork() == 0:
            time.sleep(600.0)


def _answers() -> int:
    """Return the descriptor for this process's answers, its only socket."""
    return next(
        fd
        for fd in range(3, 64)
        if os.path.exists(f"/proc/self/fd/{fd}")
        and os.readlink(f"/proc/self/fd/{fd}").startswith("socket:")
    )


def crashed(task: str, reason: str) -> str:
    return f"{task}: {reason}"


def say(task: str) -> str:
    """Print the task, and perform it."""
    print(f"said {task}")
    os.write(2, b"and more\n")
    return work(task)


def wait_a_second() -> None:
    """Wait longer than the time limit of a task."""
    time.sleep(1.0)


def never(*_):
    os._exit(5)


def hangs(*_):
    time.sleep(600.0)


def crash_in_one_scene(path, figures, task):
    """Make a part of the report, but crash in one scene."""
    from ghostball.reports import report

    if task == report.PART + "stop":
        os._exit(7)
    return report._make(path, figures, task)  # the other process has no changed functions
