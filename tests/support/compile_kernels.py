"""Compile what the tests need of the kernels, before them, in as many processes as is said.

Workers of pytest would come to the same kernels at the same time, and wait for each other. What is
made isn't done again. A variant that is missing here costs time only.
"""

import sys

from kernels import checks_bounds

from ghostball.engine.library.entry import Needed, make_all
from ghostball.engine.running import driver
from ghostball.engine.running.driver import Variant
from ghostball.engine.sensitivity import tangent_map
from ghostball.reference_adapters.stepping.kernels import KERNELS

CELLS, INTEGRATED, CONTACTS, DRAG, FLIGHT = range(5)

# What fast tests run; what takes longest comes first.
SHOTS: list[set[int]] = [
    {INTEGRATED, CONTACTS, DRAG},
    {CONTACTS, DRAG, FLIGHT},
    {INTEGRATED, CONTACTS},
    {CELLS, CONTACTS},
    {CONTACTS, FLIGHT},
    {CONTACTS, DRAG},
    {CONTACTS},
    {INTEGRATED, DRAG},
    {CELLS},
    {INTEGRATED},
    {DRAG, FLIGHT},
    {FLIGHT},
    {DRAG},
    set(),
]

# What the stress suite and slow tests run besides: shots without the skips of parts.
WHOLE = [{CELLS, INTEGRATED, CONTACTS, DRAG, FLIGHT}, {INTEGRATED, CONTACTS, DRAG, FLIGHT}]

# What tests run with bounds checked (`use_few_kernels`).
CHECKED = [WHOLE[1], {CELLS, INTEGRATED, CONTACTS}, {INTEGRATED, CONTACTS}]


def variant_with(parts: set[int]) -> Variant:
    return Variant(*(part in parts for part in range(5)))


def needed(shots: list[set[int]]) -> list[Needed]:
    """Return the kernels that tests call, with these variants of those of shots."""
    maps = [*tangent_map.needed(True), *tangent_map.needed(False)]
    return [*(driver.needed(variant_with(parts)) for parts in shots), *maps]


def main(jobs: str, what: str = "fast") -> None:
    """Compile what fast tests need, or `what` "all" tests; with bounds checked, what those do."""
    if checks_bounds():
        asked = needed(CHECKED)
    else:
        adapters = (one for kernels in KERNELS.values() for one in kernels())
        asked = [*needed(SHOTS + WHOLE if what == "all" else SHOTS), *adapters]
    if missing := sum(not one.is_made for one in asked):
        print(
            f"Compiling {missing} of the engine's kernels, once; that takes some minutes. Whoever "
            "edits one waits for those that call it, and for no others"
        )
    make_all(asked, int(jobs), print)


if __name__ == "__main__":
    main(*sys.argv[1:])
