"""The kernels that adapters run between the steps of their engines: what compiles them, by name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ghostball.engine.core.kernel import compiled
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine


@dataclass(frozen=True)
class AdapterKernels:
    """Kernels that are compiled together, as `engine.compilation.Variants` are.

    Attributes
    ----------
    name : str
        What messages, and the cache, call them: one of `SteppingSettings.kernels`.
    """

    name: str
    contacts = False

    @property
    def names(self) -> list[str]:
        """Their name."""
        return [self.name]

    @property
    def are_compiled(self) -> bool:
        """Whether they are in the cache."""
        return compiled(self.name)

    def compile(self) -> None:
        """Compile them, or load what is in the cache."""
        from ghostball.reference_adapters.stepping import cloth, contact_time  # noqa: PLC0415

        {"cloth between steps": cloth.warm_up, "contact times": contact_time.warm_up}[self.name]()


def adapter_kernels(labels: Iterable[str]) -> list[AdapterKernels]:
    """Return what these engines need of such kernels; one that can't run here needs none."""
    names: dict[str, None] = {}
    for label in labels:
        try:
            settings = make_engine(label).settings
        except EngineUnavailableError:
            continue
        names |= dict.fromkeys(getattr(settings, "kernels", ()))
    return [AdapterKernels(name) for name in names]
