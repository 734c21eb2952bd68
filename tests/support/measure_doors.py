"""Print how long the lean kernel of shots compiles, by both private doors of numba and without.

`python tests/support/measure_doors.py [ROUNDS]`: three minutes a round. Each compilation has a
process of its own; times are the processor's, the least of all rounds.
"""

import gc
import os
import subprocess
import sys
import time

from ghostball.engine.library import processor, table
from ghostball.engine.running import driver
from ghostball.engine.running.variants import Variant

WAYS = ("both doors", "without `by_common_types`", "without both")


def seconds(way: str) -> float:
    """Compile in this process; return its processor time [s]."""
    from ghostball.engine.library import build, numba_doors, plain_numba

    if way == WAYS[1]:
        numba_doors.by_common_types = lambda dispatcher: dispatcher
    if way == WAYS[2]:
        build._WAY[:] = [plain_numba.Plain()]
    gc.disable()
    needed = driver.needed(Variant.LEAN)
    kernel = needed.kernel.function
    result = table.kind_of_result(kernel)
    before = time.process_time()
    build._in_one_piece(build.object_code, kernel, needed.kinds, result, processor.target())
    return time.process_time() - before


def main(rounds: int) -> None:
    """Print a line for each way."""
    settings = {
        "NUMBA_CPU_NAME": processor.target(),
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING": "1",
    }
    least = dict.fromkeys(WAYS, float("inf"))
    for _ in range(rounds):
        for way in WAYS:
            made = subprocess.run(
                [sys.executable, __file__, "--way", way],
                env={**os.environ, **settings},
                capture_output=True,
                text=True,
                check=True,
            )
            least[way] = min(least[way], float(made.stdout))
    for way, found in least.items():
        print(f"{way:28} {found:6.1f} s  x{found / least[WAYS[0]]:.2f}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--way"]:
        print(seconds(sys.argv[2]))
    else:
        main(int(*sys.argv[1:] or [1]))
