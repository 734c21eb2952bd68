"""Compile what the tests need of the kernels, before them, in as many processes as is said.

Workers of pytest would come to the same kernels at the same time, and wait for each other. What is
made isn't done again. A variant that is missing here costs time only.
"""

import sys

from kernels import checks_bounds, use_whole_kernels

from ghostball.engine.library.entry import Needed, make_all
from ghostball.engine.running import driver
from ghostball.engine.running.driver import Variant
from ghostball.engine.sensitivity import tangent_map
from ghostball.reference_adapters.stepping.kernels import KERNELS

CELLS, INTEGRATED, CONTACTS, DRAG, FLIGHT = range(5)

# What tests run; what takes longest comes first.
SHOTS = [
    {CONTACTS},
    {INTEGRATED, CONTACTS},
    {CELLS, CONTACTS},
    {CONTACTS, DRAG, FLIGHT},
    {CONTACTS, FLIGHT},
    {CONTACTS, DRAG},
    {CELLS},
    {INTEGRATED},
    {DRAG, FLIGHT},
    {FLIGHT},
    {DRAG},
    set(),
]

# What they run where bounds are checked.
if checks_bounds():
    use_whole_kernels()
    SHOTS = [{INTEGRATED, CONTACTS, *one} for one in (set(), {CELLS}, {DRAG}, {FLIGHT})]
    SHOTS.append({INTEGRATED})  # of a test of runs that begin without contacts


def variant_with(parts: set[int]) -> Variant:
    return Variant(*(part in parts for part in range(5)))


def needed() -> list[Needed]:
    """Return the kernels that tests call."""
    shots = [driver.needed(variant_with(parts)) for parts in SHOTS]
    maps = [*tangent_map.needed(True), *tangent_map.needed(False)]
    return [*shots, *maps, *(one for kernels in KERNELS.values() for one in kernels())]


if __name__ == "__main__":
    make_all(needed(), int(sys.argv[1]), print)
