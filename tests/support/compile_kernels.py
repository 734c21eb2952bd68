"""Compile the kernels that the tests need: `compile_kernels.py PROCESSES`.

Without this program, the workers of pytest would need the same kernels at the same time, and wait
for each other. Compiled kernels are reused. Kernels that this program doesn't compile are compiled
in the tests.
"""

import sys

from kernels import checks_bounds

from ghostball.engine.library.entry import make_all
from ghostball.engine.needed_kernels import every_kernel
from ghostball.reference_adapters.stepping.kernels import KERNELS


def main(jobs: str) -> None:
    """Compile both kernels of shots and, unless bounds are checked, those of the adapters."""
    asked = every_kernel()
    if not checks_bounds():
        asked += [one for kernels in KERNELS.values() for one in kernels()]
    if missing := sum(not one.is_made for one in asked):
        print(
            f"Compiling {missing} of the engine's kernels, once; this takes some minutes. After an "
            "edit, only the edited kernel and the kernels that call it are compiled again"
        )
    make_all(asked, int(jobs), print)


if __name__ == "__main__":
    main(*sys.argv[1:])
