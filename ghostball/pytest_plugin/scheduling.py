"""How pytest-xdist hands out tests: those of a scene to one process."""

from __future__ import annotations

from xdist.scheduler import LoadScopeScheduling

from ghostball.pytest_plugin.names import PREFIX


class SceneScheduling(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Our tests scene by scene, every other test by itself."""

    def _split_scope(self, nodeid: str) -> str:
        return nodeid.rpartition("::")[0] if nodeid.startswith(PREFIX) else nodeid
