"""The processor types for which libraries are compiled, and the type of this processor."""

from __future__ import annotations

import ctypes
import os
import platform
import subprocess
import sys
from functools import cache
from pathlib import Path

from ghostball.model.errors import GhostballError

WIDE = "x86-64-v3"
"""Processors of the last ten years, with vectors of four doubles (AVX2)."""

GENERIC = {"x86_64": "x86-64", "arm64": "generic"}
"""LLVM's name for the oldest processor of each machine type."""

NEEDED = frozenset(("abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"))
"""Linux's names of the features of `WIDE` beyond `x86-64`; macOS' names differ for LZCNT only."""

BUILD_FOR = "GHOSTBALL_BUILD_FOR"
"""Environment variable with the machine type to compile libraries for, if it differs from this one,
such as "arm64".

`CC` must then name a linker for that machine.
"""

_TRIPLES = {"x86_64": "x86_64-unknown-linux-gnu", "arm64": "aarch64-unknown-linux-gnu"}

_AVX2 = 40
"""Windows' code of AVX2, PF_AVX2_INSTRUCTIONS_AVAILABLE; such processors have all of `NEEDED`."""


def machine() -> str:
    """Return the machine type: one name each for x86-64 and arm64, whatever the system calls it."""
    name = (os.environ.get(BUILD_FOR) or platform.machine()).lower()
    return {"amd64": "x86_64", "aarch64": "arm64"}.get(name, name)


def system() -> str:
    """Return the platform of a library: system and machine type."""
    return f"{sys.platform}-{machine()}"


def other_triple() -> str | None:
    """Return LLVM's name of the machine to compile for if it isn't this one, else None."""
    if not os.environ.get(BUILD_FOR):
        return None
    if machine() not in _TRIPLES:
        raise GhostballError(f"{BUILD_FOR} must be one of {sorted(_TRIPLES)}, got {machine()!r}")
    return _TRIPLES[machine()]


@cache
def target() -> str:
    """Return LLVM's name of the processor type to compile for on this machine."""
    if machine() == "x86_64" and has_wide_vectors():
        return WIDE
    return GENERIC.get(machine(), "generic")


def has_wide_vectors() -> bool:
    """Return whether this processor is of the type `WIDE`."""
    if sys.platform == "win32":
        return bool(ctypes.windll.kernel32.IsProcessorFeaturePresent(_AVX2))
    return features() >= NEEDED


def features() -> frozenset[str]:
    """Return the processor's features as the system reports them; empty if it doesn't."""
    try:
        if sys.platform == "darwin":
            names = ["features", "leaf7_features", "extfeatures"]
            names = [f"machdep.cpu.{name}" for name in names]
            command = ["sysctl", "-n", *names]
            asked = subprocess.run(command, capture_output=True, text=True, check=False)
            return frozenset(asked.stdout.lower().replace("lzcnt", "abm").split())
        told = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return frozenset()
    return frozenset(told.partition("\nflags")[2].partition("\n")[0].split())
