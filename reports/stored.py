"""Measurements that a results folder holds, or else the committed one of this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from ghostball.validation.bench import Measurement
from ghostball.validation.bench.measurements import load, machine_name, stored_paths
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.store import Results

Measured = TypeVar("Measured", bound=Measurement)


def stored_in(results: Results, kind: type[Measured]) -> Measured | None:
    """Return the measurement that `ghostball bench ... --out FOLDER` put there, or None."""
    path = results.path / file_of(kind)
    return load(path, kind) if path.exists() else None


def file_of(kind: type[Measurement]) -> str:
    """Return the name of the file that holds such a measurement in a results folder."""
    return f"{_name_of(kind)}.json"


def committed(kind: type[Measured]) -> Measured | None:
    """Return the committed measurement of this machine, else of the first; None without any."""
    paths = stored_paths(_name_of(kind))
    mine = [path for path in paths if _machine_of(path) == machine_name(describe_environment())]
    return load((mine or paths)[0], kind) if paths else None


def _machine_of(path: Path) -> str:
    return path.parent.name


def _name_of(kind: type[Measurement]) -> str:
    return str(kind.model_fields["kind"].default)
