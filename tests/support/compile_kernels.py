"""Compile what the tests need of the kernels, before them, in as many processes as is said.

Workers of pytest would compile the same variants at the same time, each for itself, and under
coverage, which makes the compiler half as slow again. Here each is compiled once, in one of the
processes; what the cache holds isn't done again. A variant that is missing here costs time only.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from kernels import checks_bounds, use_whole_kernels

from ghostball.engine.core import kernel
from ghostball.engine.running import driver
from ghostball.engine.running.driver import Variant
from ghostball.engine.sensitivity import tangent_map

CELLS, INTEGRATED, CONTACTS, DRAG, FLIGHT = range(5)

# What tests run; what takes longest comes first.
SHOTS = [
    {CONTACTS},
    {INTEGRATED, CONTACTS},
    {CELLS, CONTACTS},
    {CONTACTS, FLIGHT},
    {CONTACTS, DRAG},
    {CELLS},
    {INTEGRATED},
    {FLIGHT},
    {DRAG},
    set(),
]

# What they run where bounds are checked.
if checks_bounds():
    use_whole_kernels()
    SHOTS = [{INTEGRATED, CONTACTS, *one} for one in (set(), {CELLS}, {DRAG}, {FLIGHT})]


def variant_with(parts: set[int]) -> Variant:
    return Variant(*(part in parts for part in range(5)))


def missing() -> list[Variant | None]:
    """Return the variants of shots that the cache lacks, and None for derivatives along a shot."""
    every = [*map(variant_with, SHOTS)]
    every.insert(2, None)
    return [
        one for one in every if not kernel.compiled(one.name("shots") if one else "sensitivity")
    ]


def compile_one(variant: Variant | None) -> None:
    if variant is None:
        tangent_map._warm_up(False)
    else:
        driver.warm_up(variant)


if __name__ == "__main__":
    todo = missing()
    with ProcessPoolExecutor(int(sys.argv[1]), mp_context=get_context("spawn")) as pool:
        for done in [pool.submit(compile_one, one) for one in todo]:
            done.result()
