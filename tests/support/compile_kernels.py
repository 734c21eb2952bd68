"""Compile what the tests need of the kernels, before them, in as many processes as is said.

Workers of pytest would come to the same kernels at the same time, and wait for each other. What is
made isn't done again. A variant that is missing here costs time only.
"""

import sys

from kernels import checks_bounds

from ghostball.engine.library.entry import Needed, make_all
from ghostball.engine.running import driver
from ghostball.engine.running.driver import Variant
from ghostball.reference_adapters.stepping.kernels import KERNELS

# What fast tests run; what takes longest comes first.
SHOTS = [
    Variant(cells=False, drag=True, flight=True),
    Variant(cells=True),
    Variant(cells=False, flight=True),
    Variant(cells=False, drag=True),
    Variant(cells=False),
]

# What the stress suite and slow tests run besides: shots without the skips of parts.
WHOLE = [Variant(cells=True, drag=True, flight=True)]

# What tests run with bounds checked (`use_few_kernels`).
CHECKED = [
    Variant(cells=False, drag=True, flight=True),
    Variant(cells=True),
    Variant(cells=False),
]


def needed(shots: list[Variant]) -> list[Needed]:
    """Return the kernels that tests call, with these variants of those of shots."""
    return [driver.needed(variant) for variant in shots]


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
