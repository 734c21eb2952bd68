"""A kernel with the same kinds of arguments as the kernels of shots, compiled in a second.

As a script, the module compiles the kernel with the installed numba, and prints the way of
compiling and the results.
"""

from __future__ import annotations

import json
import math
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ghostball.engine.core.kernel import by_reference, kernel
from ghostball.engine.library import load, processor, table
from ghostball.engine.library.entry import Call, Code
from ghostball.engine.library.reached import REFERENCE_WORDS
from ghostball.model.arrays import FloatArray, IntArray


class Rows(NamedTuple):
    """Arrays that are passed by one address."""

    x: FloatArray  # (n, 3)
    counts: IntArray  # (n,), of half a word each


@kernel
def power(x: float, count: int) -> float:
    """Return x to an integer power."""
    product = 1.0
    for _ in range(count):
        product *= x
    return product


@kernel(inline=True)
def length(rows: Rows, i: int) -> float:
    """Return the length of a row."""
    flat = rows.x.reshape(3 * len(rows.x))
    return math.sqrt(power(flat[3 * i], 2) + power(flat[3 * i + 1], 2) + flat[3 * i + 2] ** 2)


@kernel
def write(rows: Rows, out: FloatArray) -> int:
    """Write a number for each row."""
    for i in range(len(out)):
        rows.counts[i] += 1
        out[i] = power(rows.x[i, 0], 3) / length(rows, i) + power(0.9, rows.counts[i])
    return len(out)


@kernel(entry=True)
def computed(
    x: FloatArray, counts: IntArray, scale: float, memory: FloatArray, out: FloatArray
) -> int:
    """Write a number for each row, and return how many there are."""
    count = write(by_reference(Rows(x, counts), memory), out)
    for i in range(count):
        out[i] *= scale
    return count


def arguments() -> tuple[Any, ...]:
    """Return arguments of `computed`, the same each time."""
    random = np.random.default_rng(7)
    x, counts = random.normal(size=(100, 3)), np.arange(100, dtype=np.int32)
    return x, counts, 0.3, np.zeros(REFERENCE_WORDS), np.full(100, np.nan)


def compiled_bits() -> str:
    """Compile the kernel in this process, call it, and return all bytes that it wrote."""
    from ghostball.engine.library import build

    given = arguments()
    kinds = [table.kind_of(one) for one in given]
    made = build.object_code(computed.function, kinds, processor.target())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "kernel.o")
        path.write_bytes(made)
        code = Code(computed.function, kinds, load.entry_of(path))
        assert Call(code, given)() == 100
    return bits(given)


def bits(given: tuple[Any, ...]) -> str:
    """Return the bytes that `computed` wrote into its arguments."""
    return bytes(given[1].tobytes() + given[4].tobytes()).hex()


def main() -> None:
    """Compile the kernel; print the version of numba, the way of compiling, and the results."""
    import numba

    from ghostball.engine.library.build import way

    found = {"bits": compiled_bits(), "numba": numba.__version__, "way": type(way()).__name__}
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
