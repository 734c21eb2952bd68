"""`pytest --ghostball`: anyone's engine through the suite, one test for each scene and metric.

    pytest --ghostball --ghostball-engine my_engine:simulate
    pytest 'ghostball::half-ball-cut::overlap_max' --ghostball-engine my_engine:simulate

A test is called `ghostball::SCENE::METRIC`; the first of a scene, `completes`, asks that the run
ends by itself with finite numbers. Tests can be named on the command line like any other;
`ghostball::` is all of them, and none of yours. A scene runs once for all its tests, also under
pytest-xdist, and in another process: an engine that crashes or hangs fails its scene alone.

What `[tool.ghostball]` in `pyproject.toml` says of engines, scenes and baselines holds here too.
Where the engine has accepted baselines (`ghostball regress`, `ghostball accept`), each scene that
has one is compared with it, in the test `baseline`.

The limits are those of `ghostball validate` for any engine (`validation.checks.requirements`), and
those in the file of `--ghostball-criteria`. A scene that an engine doesn't support is skipped, and
so is the end of a shot that errors of its size make unpredictable.

Every pytest in the environment loads this module: without the option it does nothing, and it
imports nothing but pytest.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import pytest

from ghostball.pytest_plugin.names import PREFIX, TIME_LIMIT

if TYPE_CHECKING:
    from xdist.scheduler import LoadScopeScheduling

_PICKED = pytest.StashKey[Sequence[str]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options; those beside `--ghostball` may stand in `addopts`."""
    group = parser.getgroup("ghostball", "Ghostball: checks of billiards engines")
    group.addoption(
        "--ghostball",
        action="store_true",
        help="Check an engine in Ghostball's scenes, one test for each scene and metric.",
    )
    group.addoption(
        "--ghostball-engine",
        metavar="NAME|MODULE:NAME[:KEY=VALUE,...]",
        help="Engine: the name of an installed one, or a function or class in a module, with "
        "settings (default: that of [tool.ghostball] in pyproject.toml, else ghostball).",
    )
    group.addoption(
        "--ghostball-scenes",
        metavar="full|SCENE|TAG|FILE,...",
        help="Scenes: names, tags, TOML files, or full for all shipped scenes (default: those of "
        "[tool.ghostball] in pyproject.toml, else smoke).",
    )
    group.addoption(
        "--ghostball-baselines",
        metavar="DIR",
        help="Folder of the accepted baselines (default: that of [tool.ghostball] in "
        "pyproject.toml, else baselines).",
    )
    group.addoption(
        "--ghostball-criteria",
        metavar="FILE",
        help="File of limits for all scenes, such as on rest errors, in the format of "
        "NAME.expect.toml.",
    )
    group.addoption(
        "--ghostball-as",
        metavar="NAME[:KEY=VALUE,...]",
        help="Apply the limits of another engine, such as ghostball or pymunk:contact_steps=exact.",
    )

    group.addoption(
        "--ghostball-time-limit",
        metavar="SECONDS",
        type=float,
        default=TIME_LIMIT,
        help="Time limit for a scene. The engine runs in its own process: a crash or a hang "
        "fails only that scene. inf: no limit, and the engine runs in pytest's process, which a "
        "debugger or coverage needs (default: %(default)g).",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Take a test of ours on the command line for `--ghostball`."""
    if any(argument.startswith(PREFIX) for argument in config.args):
        config.option.ghostball = True


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Take tests of ours out of the arguments, which pytest takes for files."""
    config = session.config
    config.stash[_PICKED] = [one for one in config.args if one.startswith(PREFIX)]
    config.args[:] = [one for one in config.args if not one.startswith(PREFIX)]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Add the tests, before `-k` and its like choose among all."""
    if config.option.ghostball:
        from ghostball.pytest_plugin.items import collect  # noqa: PLC0415

        items.extend(collect(session, config.stash.get(_PICKED, ())))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadScopeScheduling | None:
    """Keep the tests of a scene together, so that it runs once, where xdist would spread them."""
    if not config.option.ghostball or config.getvalue("dist") != "load":
        return None
    from ghostball.pytest_plugin.scheduling import SceneScheduling  # noqa: PLC0415

    return SceneScheduling(config, log)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """End with the status of "not judged" if no shot was judged, as the commands do."""
    config = session.config
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    if not config.option.ghostball or exitstatus != pytest.ExitCode.OK or terminal is None:
        return
    from ghostball.pytest_plugin.items import unjudged  # noqa: PLC0415
    from ghostball.validation.exit_status import ExitStatus  # noqa: PLC0415

    if unjudged(report for found in terminal.stats.values() for report in found):
        session.exitstatus = int(ExitStatus.NOT_JUDGED)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say what the rest errors were, which are measured also where no limit judges them."""
    if terminalreporter.config.option.ghostball:
        from ghostball.pytest_plugin.items import summary_lines  # noqa: PLC0415

        reports = [report for found in terminalreporter.stats.values() for report in found]
        if lines := summary_lines(reports):
            terminalreporter.section("ghostball")
            for line in lines:
                terminalreporter.line(line)
