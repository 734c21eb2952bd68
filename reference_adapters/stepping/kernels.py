"""The kernels that adapters run between the steps of their engines, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ghostball.engine.library.entry import Needed
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.reference_adapters.stepping import cloth, contact_time

KERNELS: dict[str, Callable[[], tuple[Needed, ...]]] = {
    "cloth between steps": cloth.needed,
    "contact times": contact_time.needed,
}
"""The kernels for each name in `SteppingSettings.kernels`."""


def adapter_kernels(labels: Iterable[str]) -> list[Needed]:
    """Return the kernels that the adapters of these engines need; unavailable engines need none."""
    names: dict[str, None] = {}
    for label in labels:
        try:
            settings = make_engine(label).settings
        except EngineUnavailableError:
            continue
        names |= dict.fromkeys(getattr(settings, "kernels", ()))
    return [one for name in names for one in KERNELS[name]()]
