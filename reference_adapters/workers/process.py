"""A process that simulates scenes: a line of JSON in, a line of JSON out, in any language.

The process starts with the line {"version": "1.2"}, or prints {"absent": reason} and exits. It then
gets lines

    {"scene": {...}, "record": "rest" | "events" | "trajectory"}

with "settings" in addition if the engine has settings; the scene is as written by
`ghostball scenes --export`. It answers each line with a result object, see
`reference_adapters.answer`, whose `samples` contain at least the final state; or with
{"cannot": reason} if it doesn't support the scene, or {"error": message}.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import subprocess
import tempfile
import threading
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import IO, Any

from ghostball.model import Record, Scene

SCRIPTS = Path(__file__).resolve().parent / "scripts"

PYTHON = "GHOSTBALL_PEERS_PYTHON"
"""Environment variable for the interpreter."""

PEERS_VENV = Path(__file__).resolve().parents[2] / ".venv-peers"
"""Default environment, created by `make peers`: engines have requirements that conflict."""

DISTRIBUTIONS = ("pooltool-billiards", "billiards")
"""Distributions of the engines of the workers."""

_LIST_PACKAGES = (
    "import json, platform; from importlib.metadata import distributions; "
    "found = {one.metadata['Name']: one.version for one in distributions()}; "
    "print(json.dumps(found | {'Python': platform.python_version()}))"
)


def interpreter() -> Path:
    """Return the interpreter of the workers, which may not exist."""
    return Path(os.environ.get(PYTHON) or PEERS_VENV / "bin" / "python")


def installed() -> Mapping[str, str]:
    """Return the versions of all packages in the workers' interpreter; empty if there is none.

    All packages are listed, because any dependency of an engine may change its results.
    """
    python = interpreter()
    try:
        changed = (
            python.stat().st_mtime_ns,
            *(path.stat().st_mtime_ns for path in python.parent.parent.glob("lib/*/site-packages")),
        )
    except OSError:
        return {}
    return _installed(python, changed)


@cache
def _installed(python: Path, changed: tuple[int, ...]) -> Mapping[str, str]:  # noqa: ARG001 - key of the cache
    done = subprocess.run(
        [str(python), "-I", "-c", _LIST_PACKAGES], capture_output=True, text=True, check=False
    )
    if done.returncode:  # no Python: the engines report this when they are used
        return {}
    found: dict[str, str] = json.loads(done.stdout)
    return found


class WorkerAbsentError(Exception):
    """A worker that can't start because its interpreter or its engine is missing."""


class WorkerFailedError(Exception):
    """A worker that exited, reached the time limit, or answered with an error."""


class Worker:
    """A worker process; it starts with the first scene, and again after a failure.

    Programs that it starts end with it. Inside a process of `validation.parallel.pool` it stays in
    the group of that process, which ends as a whole; otherwise it leads a separate group.

    `environment`: environment of the process; None is that of Ghostball.
    """

    def __init__(self, command: list[str], environment: Mapping[str, str] | None = None) -> None:
        self._command = command
        self._environment = environment
        self._process: subprocess.Popen[str] | None = None
        self._messages: IO[str] | None = None
        self._leads_group = hasattr(os, "killpg") and multiprocessing.parent_process() is None

    def play(
        self,
        scene: Scene,
        record: Record,
        longest: float,
        settings: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Send a scene and return the answer.

        `longest`: time limit for the answer, and for the start of the process [s].
        `settings`: additional settings, if the engine takes any.

        Raises `WorkerAbsentError` if the worker can't start; `WorkerFailedError` if it fails.
        """
        if self._process is None:
            self._start(longest)
        values = scene.without_strikes().model_dump(mode="json", by_alias=True)
        asked = {"scene": values, "record": record}
        if settings is not None:
            asked["settings"] = dict(settings)
        answer = self._ask(json.dumps(asked), longest)
        if "error" in answer:
            raise WorkerFailedError(str(answer["error"]))
        if (answered := answer.get("scene", scene.name)) != scene.name:
            self.close()  # the next answers may also be for different scenes
            raise WorkerFailedError(
                f"its process must answer for the requested scene, {scene.name!r}, got "
                f"{str(answered)[:80]!r}"
            )
        return answer

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            self._kill(process)
            process.wait()
            for stream in (process.stdin, process.stdout, self._messages):
                if stream is not None:
                    stream.close()

    def _kill(self, process: subprocess.Popen[str]) -> None:
        if self._leads_group:
            with suppress(ProcessLookupError, PermissionError):  # macOS: the whole group has ended
                os.killpg(process.pid, signal.SIGKILL)
        process.kill()

    def _start(self, longest: float) -> None:
        self._messages = tempfile.TemporaryFile(mode="w+")  # noqa: SIM115 - `close` closes it
        try:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._messages,
                env=self._environment,
                text=True,
                start_new_session=self._leads_group,
            )
        except OSError as error:
            self._messages.close()
            raise WorkerAbsentError(str(error)) from None
        hello = self._ask(None, longest)
        if "absent" in hello:
            self.close()
            raise WorkerAbsentError(str(hello["absent"]))
        if "version" not in hello:
            self.close()
            raise WorkerFailedError(
                f'its process must start with {{"version": ...}}, got {str(hello)[:80]}'
            )

    def _ask(self, line: str | None, longest: float) -> dict[str, Any]:
        """Send a line, if there is one, and read the answer."""
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        late, printed = threading.Event(), ""

        def give_up() -> None:
            late.set()
            self._kill(process)

        watch = threading.Timer(longest, give_up)
        watch.start()
        try:
            if line is not None:
                process.stdin.write(line + "\n")
                process.stdin.flush()
            printed = process.stdout.readline()
            answer: object = json.loads(printed)
            if isinstance(answer, dict):
                return answer
        except (OSError, ValueError):
            said = f"over {longest:.0f} s" if late.is_set() else self._last_message()
            self.close()
            if printed and not late.is_set():
                raise _not_an_object(printed) from None
            raise WorkerFailedError(f"its process ended without an answer: {said}") from None
        except KeyboardInterrupt:
            self.close()
            raise
        finally:
            watch.cancel()
        self.close()
        raise _not_an_object(printed)

    def _last_message(self) -> str:
        assert self._messages is not None
        self._messages.seek(0)
        return "".join(self._messages.read().strip().splitlines()[-1:])


def _not_an_object(printed: str) -> WorkerFailedError:
    return WorkerFailedError(
        f"its process must answer with one JSON object on a line, got {printed.strip()[:80]!r}"
    )
