"""Calls the law that a scene chose, by its place in `registry`."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from engine.core.kernel import kernel
from engine.core.state import Laws
from engine.impacts.laws.interface import BallImpact, BallImpulse, CushionBounce, CushionImpact
from engine.impacts.laws.registry import BALL_LAWS, CUSHION_LAWS, LawEntry


def _chosen(name: str, entries: tuple[LawEntry, ...]) -> Any:
    """Return a kernel that calls the law of the given code; the first of them where none has it.

    A chain of comparisons, because the compiler can't cache a kernel that is handed another one. It
    is written here from the registry, so that no law is forgotten, nor needs a line in this file.
    The compiler leaves out what follows `is not None` where the type of an argument is None.
    """
    # The compiler's cache asks for the module that a function is of.
    kernels: dict[str, Any] = {"__name__": __name__}
    lines = [f"def {name}(impact, laws, law, integrated):"]
    for code, entry in enumerate(entries):
        module, _, function = entry.kernel.partition(".")
        call = f"{module}_{function}"
        kernels[call] = getattr(import_module(f"engine.impacts.laws.{module}"), function)
        asked = "integrated is not None and " if entry.integrated else ""
        if entry.kernel != entries[0].kernel:
            lines += [f"    if {asked}law == {code}:", f"        return {call}(impact, laws)"]
    module, _, function = entries[0].kernel.partition(".")
    lines.append(f"    return {module}_{function}(impact, laws)")
    exec(compile("\n".join(lines), __file__, "exec"), kernels)
    return kernel(inline=True)(kernels[name])


_ball_law = _chosen("_ball_law", BALL_LAWS)
_cushion_law = _chosen("_cushion_law", CUSHION_LAWS)


@kernel(inline=True)
def ball_law(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return what the scene's law makes of a ball-ball impact."""
    impulse: BallImpulse = _ball_law(impact, laws, laws.ball_law, laws.integrated)
    return impulse


@kernel(inline=True)
def cushion_law(impact: CushionImpact, laws: Laws, law: int) -> CushionBounce:
    """Return what a law, by its place in `registry.CUSHION_LAWS`, makes of an impact."""
    bounce: CushionBounce = _cushion_law(impact, laws, law, laws.integrated)
    return bounce
