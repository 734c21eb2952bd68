"""`pytest --ghostball`: check an engine, with one test for each scene and metric.

    pytest --ghostball --ghostball-engine my_engine:simulate
    pytest 'ghostball::half-ball-cut::overlap_max' --ghostball-engine my_engine:simulate

The name of a test is `ghostball::SCENE::METRIC`. The first test of a scene, `completes`, requires
that the run finishes with finite numbers. The names can be used on the command line; `ghostball::`
selects all tests of Ghostball, and no other tests. A scene runs once for all its tests, even with
pytest-xdist. It runs in another process, so an engine that crashes or hangs fails only that scene.

The settings `[tool.ghostball]` in `pyproject.toml` for engines, scenes and baselines apply. A scene
with an accepted baseline (`ghostball regress`, `ghostball accept`) is compared with the baseline,
in the test `baseline`.

The limits are those of `ghostball validate` for any engine (`validation.checks.requirements`), and
those in the file of `--ghostball-criteria`. Tests are skipped if the engine doesn't support the
scene, or if its errors make the quantity unpredictable.

Every pytest in the environment loads this module. Without the option it does nothing, and it
imports only pytest.
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
    """Declare the options; all except `--ghostball` can be set in `addopts` permanently."""
    group = parser.getgroup("ghostball", "Ghostball: checks of billiards engines")
    group.addoption(
        "--ghostball",
        action="store_true",
        help="Check an engine in Ghostball's scenes, one test for each scene and metric.",
    )
    group.addoption(
        "--ghostball-engine",
        metavar="NAME|MODULE:NAME[:KEY=VALUE,...]",
        help="Engine: the name of an installed engine, or a function or class in a module, with "
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
        "--ghostball-relations",
        nargs="?",
        const="",
        metavar="NAME,...",
        help="Also simulate related shots, such as the mirrored shot, and check that both runs "
        "agree: names as for `ghostball validate --relations` (without names: every relation that "
        "the scene supports).",
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
    """Set `--ghostball` if a test of Ghostball is named on the command line."""
    if any(argument.startswith(PREFIX) for argument in config.args):
        config.option.ghostball = True


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Remove the tests of Ghostball from the arguments, because pytest expects files."""
    config = session.config
    config.stash[_PICKED] = [one for one in config.args if one.startswith(PREFIX)]
    config.args[:] = [one for one in config.args if not one.startswith(PREFIX)]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Add the tests of Ghostball, before `-k` and similar options select tests."""
    if config.option.ghostball:
        from ghostball.pytest_plugin.items import collect  # noqa: PLC0415

        items.extend(collect(session, config.stash.get(_PICKED, ())))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadScopeScheduling | None:
    """Run all tests of a scene in one process of xdist, so that the scene runs once."""
    if not config.option.ghostball or config.getvalue("dist") != "load":
        return None
    from ghostball.pytest_plugin.scheduling import SceneScheduling  # noqa: PLC0415

    return SceneScheduling(config, log)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Set the exit status NOT_JUDGED if no shot was judged, as the commands do."""
    config = session.config
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    if not config.option.ghostball or exitstatus != pytest.ExitCode.OK or terminal is None:
        return
    from ghostball.pytest_plugin.items import unjudged  # noqa: PLC0415
    from ghostball.validation.exit_status import ExitStatus  # noqa: PLC0415

    if unjudged(report for found in terminal.stats.values() for report in found):
        session.exitstatus = int(ExitStatus.NOT_JUDGED)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the rest position errors, which are measured even without a limit."""
    if terminalreporter.config.option.ghostball:
        from ghostball.pytest_plugin.items import summary_lines  # noqa: PLC0415

        reports = [report for found in terminalreporter.stats.values() for report in found]
        if lines := summary_lines(reports):
            terminalreporter.section("ghostball")
            for line in lines:
                terminalreporter.line(line)
