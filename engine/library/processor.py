"""Which processors libraries are compiled for, and which of them this one is."""

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
"""What LLVM calls any processor of a machine."""

NEEDED = frozenset(("abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"))
"""What Linux calls what `WIDE` has beyond `x86-64`; so does macOS, in capitals, but for LZCNT."""

BUILD_FOR = "GHOSTBALL_BUILD_FOR"
"""Names, in the environment, a machine to compile libraries for where it isn't this one: "arm64".

`CC` must name a linker for it.
"""

_TRIPLES = {"x86_64": "x86_64-unknown-linux-gnu", "arm64": "aarch64-unknown-linux-gnu"}

_AVX2 = 40
"""What Windows calls it: PF_AVX2_INSTRUCTIONS_AVAILABLE. The others came with it."""


def machine() -> str:
    """Return the machine's name: one for each of x86-64 and arm64, whatever a system calls it."""
    name = (os.environ.get(BUILD_FOR) or platform.machine()).lower()
    return {"amd64": "x86_64", "aarch64": "arm64"}.get(name, name)


def system() -> str:
    """Return what a library runs on, by name: a system and a machine."""
    return f"{sys.platform}-{machine()}"


def other_triple() -> str | None:
    """Return what LLVM calls the machine to compile for, where that isn't this one; else None."""
    if not os.environ.get(BUILD_FOR):
        return None
    if machine() not in _TRIPLES:
        raise GhostballError(f"{BUILD_FOR} must be one of {sorted(_TRIPLES)}, got {machine()!r}")
    return _TRIPLES[machine()]


@cache
def target() -> str:
    """Return the name by which LLVM knows what to compile for, on this machine."""
    if machine() == "x86_64" and has_wide_vectors():
        return WIDE
    return GENERIC.get(machine(), "generic")


def has_wide_vectors() -> bool:
    """Whether this processor is a `WIDE` one."""
    if sys.platform == "win32":
        return bool(ctypes.windll.kernel32.IsProcessorFeaturePresent(_AVX2))
    return features() >= NEEDED


def features() -> frozenset[str]:
    """Return what the system says that the processor can do; empty where it can't be asked."""
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
