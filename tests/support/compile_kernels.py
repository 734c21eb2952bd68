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
    SHOTS.append({INTEGRATED})  # of a test of runs that begin without contacts


def variant_with(parts: set[int]) -> Variant:
    return Variant(*(part in parts for part in range(5)))


def missing() -> list[Variant | bool]:
    """Return the variants of shots that the cache lacks, and those of derivatives along a shot.

    Of these, whether the laws that integrate are in them.
    """
    every = [*map(variant_with, SHOTS)]
    every[2:2] = [True, False]
    return [one for one in every if not kernel.compiled(name_of(one))]


def name_of(one: Variant | bool) -> str:
    if isinstance(one, bool):
        return "sensitivity" + ", integrated laws" * one
    return one.name("shots")


def compile_one(one: Variant | bool) -> None:
    if isinstance(one, bool):
        tangent_map._warm_up(one)
    else:
        driver.warm_up(one)


if __name__ == "__main__":
    todo = missing()
    with ProcessPoolExecutor(int(sys.argv[1]), mp_context=get_context("spawn")) as pool:
        for done in [pool.submit(compile_one, one) for one in todo]:
            done.result()
