"""Scheduling for pytest-xdist: one process runs all tests of a scene."""

from __future__ import annotations

from xdist.scheduler import LoadScopeScheduling

from ghostball.pytest_plugin.names import PREFIX


class SceneScheduling(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Schedule the tests of Ghostball by scene, and all other tests one by one."""

    def _split_scope(self, nodeid: str) -> str:
        return nodeid.rpartition("::")[0] if nodeid.startswith(PREFIX) else nodeid
