"""What runs within a copy of our packages: shots, shipped and generated, and tests."""

from __future__ import annotations

import importlib.util
import os
import signal
import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path

# Nothing of ours, which is to come from the copy: see `try_all`.

MAX_EVENTS = 20_000
"""Events after which a shot of a copy is given up: a bug may make it continue for ever."""


def try_all(folder: str, shots: Sequence[str], processor_limit: float, answers: Connection) -> None:
    """Send why the packages in a folder can't be imported, "" where they can; then each's faults.

    A shot that takes more time of the processor than the limit [s] ends this process.

    Nothing but the bug makes the harness fail where it doesn't in a copy without one, so that a
    shot that can't be judged has a fault too.
    """
    sys.path.insert(0, folder)
    try:
        check_copies(Path(folder))
        import ghostball.validation.stress
        import ghostball.validation.suite.case  # noqa: F401
    except Exception as error:
        answers.send(f"{type(error).__name__}: {error}")
        return
    answers.send("")
    for path in shots:
        signal.setitimer(signal.ITIMER_PROF, processor_limit)
        found = faults_in(path)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        answers.send(found)


def run_tests_into(output: str, folder: str, root: str, tests: Sequence[str]) -> None:
    """As `run_tests`, in a forked process, with the output in a file."""
    with open(output, "wb", buffering=0) as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.environ["GHOSTBALL_CACHE_DIR"] = folder
    os.chdir(folder)
    sys.path.insert(0, folder)
    run_tests(folder, root, tests)


def run_tests(folder: str, root: str, tests: Sequence[str]) -> None:
    """Run tests of the checkout `root` on the packages in a folder; exit with pytest's status."""
    # Found, but not imported: pytest imports the package itself, because its plugin is part of it.
    spec = importlib.util.find_spec("ghostball")
    if spec is None or spec.origin is None or not spec.origin.startswith(folder):
        raise ImportError(f"not the copy: {spec}")
    import pytest

    options = ["-q", "-n", "0", "-p", "no:cacheprovider", "--rootdir", root]
    options += ["-c", f"{root}/pyproject.toml"]
    # The plugin of Hypothesis was imported before pytest could rewrite its assertions.
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    sys.exit(pytest.main([*options, *(f"{root}/{test}" for test in tests)]))


def faults_in(path: str) -> tuple[str, ...]:
    """Run a shot by its name on the engine that is found here, and judge it as a run would."""
    from ghostball.reference_adapters.registry import make_engine
    from ghostball.validation.checks.requirements import asked_of
    from ghostball.validation.checks.verdict import unfinished_text
    from ghostball.validation.scenes.library import find_scene
    from ghostball.validation.stress import StressSize, chosen_shots
    from ghostball.validation.suite.case import plain_settings, run_case, truth_or_failure
    from ghostball.validation.suite.judge import Case
    from ghostball.validation.suite.plan import shipped_criteria

    if path.startswith("shipped/"):
        scene = find_scene(path.removeprefix("shipped/"))
        criteria = shipped_criteria(scene)
    else:
        (shot,) = chosen_shots(StressSize(), [path])
        scene, criteria = shot.scene, shot.criteria
    label = f"ghostball:max_events={MAX_EVENTS}"
    engine = make_engine(label)
    asked = asked_of([(engine.name, plain_settings(engine))], criteria)
    truth = truth_or_failure(scene, criteria)
    record, _ = run_case(Case(scene, label, truth, asked, keeps_motion=False))
    broken = tuple(check.sentence for check in record.checks if check.passed is False)
    stopped = unfinished_text(record)
    return (stopped, *broken) if stopped else broken


def check_copies(folder: Path) -> None:
    """Make sure that each package in a folder is the one that is imported.

    Raises
    ------
    ImportError
        Where another one is: it would be taken for the copy.
    """
    for package in folder.glob("ghostball/*/__init__.py"):
        found = importlib.import_module(f"ghostball.{package.parent.name}").__file__
        if found is None or not Path(found).samefile(package):
            raise ImportError(f"not the copy: {found}")


if __name__ == "__main__":
    run_tests(*sys.argv[1:3], sys.argv[3:])
