"""One revision of an engine in a process of its own: plays shots and times them when told to.

Where that is ours, what the process runs is older or newer than this code. So it uses the engine's
public face alone, and answers in plain arrays. Any other engine is run by the ghostball that is
installed.
"""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import numpy as np

from ghostball.engine import ExactTrajectory, GhostballError, Result, Samples, Scene, Status
from ghostball.engine.core.state import KNOT
from ghostball.engine.result import EVENT_DTYPE
from ghostball.validation.truth.scene_truth import OUR_NAME

LONGEST = 600.0
"""Seconds that a command may take: the first ones compile the kernels."""

_BEGIN = """\
import json, os, pickle, sys
from statistics import median
answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # what anything prints is no answer
root, spec = sys.argv[1:]
"""

_OURS = """\
try:
    from ghostball import engine
except ImportError:  # a revision in which it was a package of its own
    import engine
place = os.path.dirname(os.path.dirname(os.path.realpath(engine.__file__)))
if not os.path.samefile(place, root):
    raise ImportError(f"not the revision asked for: {engine.__file__}")

def play(scene, out):
    run = engine.simulate(engine.Scene.load(scene), record="trajectory")
    motion = run.trajectory
    told = {
        "status": run.status.name,
        "rest_time": run.rest_time,
        "state": [part for part in run.final_state],
        "events": {name: run.events[name] for name in run.events.dtype.names},
        "counts": dict(run.collision_counts),
        "work": {name: int(count) for name, count in run.work.items()},
        "wall_time": run.wall_time,
        "reason": run.reason,
        "knots": [part for part in motion.knots],
        "turns": getattr(motion, "turns", False),
        "lifts": getattr(motion, "lifts", False),
        "spins": motion.spin_decelerations,
    }
    with open(out, "wb") as file:
        pickle.dump(told, file)

def time(scene, runs):
    if scene not in scenes:
        scenes[scene] = engine.Scene.load(scene)
        engine.simulate(scenes[scene])
    return median(engine.simulate(scenes[scene]).wall_time for _ in range(runs))
"""

_ANY = """\
from ghostball.engine import Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.runs.playing import run_engine
player = make_engine(spec)
file = os.path.realpath(sys.modules[type(player).__module__].__file__)
if os.path.commonpath([file, os.path.realpath(root)]) != os.path.realpath(root):
    raise ImportError(f"not the revision asked for: {file}")

def play(scene, out):
    run = run_engine(player, Scene.load(scene))
    with open(out, "wb") as file:
        pickle.dump(run, file)

def time(scene, runs):
    if scene not in scenes:
        scenes[scene] = Scene.load(scene)
        run_engine(player, scenes[scene], "rest")
    return median(run_engine(player, scenes[scene], "rest").wall_time for _ in range(runs))
"""

_SERVE = """\
scenes = {}
print(json.dumps({"ready": True}), file=answers, flush=True)
for line in sys.stdin:
    asked = json.loads(line)
    try:
        answer = {"answer": {"play": play, "time": time}[asked.pop("do")](**asked)}
    except Exception as error:
        answer = {"error": f"{type(error).__name__}: {error}"}
    print(json.dumps(answer), file=answers, flush=True)
"""


class NotComparableError(GhostballError):
    """A revision that can't be built or run, so that there is nothing to compare with."""


class PlayError(GhostballError):
    """A scene that a revision can't play; the message is what it said."""


class Player:
    """A revision that plays; see `playing`."""

    def __init__(self, name: str, process: subprocess.Popen[str], messages: IO[str]) -> None:
        self.name = name
        self._process = process
        self._messages = messages
        if "ready" not in self._answer():
            raise NotComparableError(f"{self.name} doesn't answer as it should")

    def play(self, scene: Scene, path: Path) -> Result:
        """Play the scene that lies at `path`, and return what our own engine would.

        Raises
        ------
        PlayError
            Where the revision refuses the scene, or tells of it in another form.
        NotComparableError
            Where its process ends.
        """
        with tempfile.TemporaryDirectory() as place:
            out = Path(place, "played")
            self._ask(do="play", scene=str(path), out=str(out))
            told = pickle.loads(out.read_bytes())
        if isinstance(told, Result):
            return told
        try:
            return _result(scene, told)
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise PlayError(f"{self.name} tells of its motion in another form: {error}") from error

    def seconds(self, path: Path, runs: int) -> float:
        """Return the median run time of some runs in a row [s]; errors as `play`."""
        return float(self._ask(do="time", scene=str(path), runs=runs))

    def _ask(self, **command: Any) -> Any:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(command) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._ended() from None
        answer = self._answer()
        if "error" in answer:
            raise PlayError(f"{self.name}: {answer['error']}")
        return answer["answer"]

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        overdue = threading.Event()

        def end() -> None:
            overdue.set()
            self._process.kill()

        watch = threading.Timer(LONGEST, end)
        watch.start()
        try:
            line = self._process.stdout.readline()
        finally:
            watch.cancel()
        if overdue.is_set():
            raise NotComparableError(
                f"{self.name} took over {LONGEST:.0f} s for one scene, and was ended. Nothing can "
                "be compared with it; choose other scenes, or another revision"
            )
        if not line.endswith("\n"):
            raise self._ended()
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _ended(self) -> NotComparableError:
        self._process.kill()
        code = self._process.wait()
        self._messages.seek(0)
        said = (self._messages.read().strip().splitlines() or ["no message"])[-1]
        return NotComparableError(
            f"{self.name} can't be built or run here: exit code {code}: {said}. Nothing can be "
            "compared with it; choose another revision"
        )


@contextmanager
def playing(name: str, root: Path, label: str = OUR_NAME, below: str = ".") -> Iterator[Player]:
    """Start a process that plays with the code in `root`; it ends with the block.

    Parameters
    ----------
    name : str
        What messages call it.
    root : Path
    label : str
        The engine, as it was asked for.
    below : str
        Where in `root` its package is imported from.

    Raises
    ------
    NotComparableError
        Where that can't even be imported.
    """
    paths = [str(root / below), *filter(None, [os.environ.get("PYTHONPATH")])]
    with (
        tempfile.TemporaryFile(mode="w+") as messages,
        subprocess.Popen(
            [
                *(sys.executable, "-c", _BEGIN + (_OURS if label == OUR_NAME else _ANY) + _SERVE),
                *(str(root), label),
            ],
            cwd=root,  # which python looks into first
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=messages,
            text=True,
        ) as process,
    ):
        try:
            yield Player(name, process, messages)
        finally:
            process.kill()
            assert process.stdin is not None
            with suppress(BrokenPipeError):  # what it was not told any more
                process.stdin.close()


def _motion(scene: Scene, told: dict[str, Any]) -> ExactTrajectory:
    """Return the motion that was told of, which must have the columns of this version's.

    Raises
    ------
    ValueError
        Where it hasn't.
    """
    turns, lifts, knots = bool(told["turns"]), bool(told["lifts"]), tuple(told["knots"])
    least, step = KNOT + 3 * lifts, 4 if turns else 2
    if len(knots) != len(scene.balls):
        raise ValueError(f"there must be knots of {len(scene.balls)} balls, got {len(knots)}")
    for rows in knots:
        fits = rows.ndim == 2 and len(rows) > 0 and rows.shape[1] == knots[0].shape[1]
        if (
            not fits
            or rows.dtype != np.float64
            or rows.shape[1] < least
            or ((rows.shape[1] - least) % step)
        ):
            raise ValueError(
                f"knots must be float64 with shape (k, {least} + {step} m), got {rows.dtype} with "
                f"shape {rows.shape}"
            )
    return ExactTrajectory(scene.radii, knots, told["rest_time"], told["spins"], turns, lifts)


def _result(scene: Scene, told: dict[str, Any]) -> Result:
    events = np.empty(len(told["events"]["t"]), dtype=EVENT_DTYPE)
    for column in EVENT_DTYPE.names or ():
        events[column] = told["events"][column]
    return Result(
        engine="ghostball",
        settings={},
        scene=scene,
        status=Status[told["status"]],
        final_state=Samples(*told["state"]),
        rest_time=told["rest_time"],
        collision_counts=told["counts"],
        work=told["work"],
        wall_time=told["wall_time"],
        events=events,
        trajectory=_motion(scene, told),
        reason=told["reason"],
    )
