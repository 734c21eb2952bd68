"""Read files of runs made outside Ghostball, by an engine in any language; see `answer`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, ClassVar

from ghostball.model import Record, Result, Scene
from ghostball.model.errors import storable
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.model.text_files import read_text
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.reference_adapters.base import EngineBase, EngineError, ReferenceEngine

_FOR_GOLDEN = "For golden shots use `--golden DIR`"


def load_runs(path: Path) -> tuple[EngineAnswer, ...]:
    """Read a file of one run, a list of runs, or one run per line.

    Raises `EngineError` if the file can't be read or a run is invalid; the message gives the
    location.
    """
    if path.is_dir():
        raise EngineError(f"{path} must be a file, got a folder. {_FOR_GOLDEN}")
    text = _text_of(path)
    try:
        values = _json_of(text, path)
    except ValueError:  # also raised if the nesting is too deep
        try:
            lines = [line for line in text.splitlines() if line.strip()]
            values = [_json_of(line, path) for line in lines]
        except ValueError as error:
            raise EngineError(
                f"{path} isn't valid JSON: {error}. Write one run, a list of runs, or one run per "
                "line"
            ) from None
    listed = values if isinstance(values, list) else [values]
    if not listed:
        raise EngineError(f"{path} must hold at least one run, got none")
    if isinstance(values, dict) and any(
        isinstance(one, dict) and isinstance(one.get("events"), list) for one in values.values()
    ):
        raise EngineError(f"{path} holds answers by name instead of runs. {_FOR_GOLDEN}")
    return tuple(EngineAnswer.parse(value, f"{path}, run {k}") for k, value in enumerate(listed, 1))


def load_object(path: Path) -> dict[str, Any]:
    """Read a file of one JSON object.

    Raises `EngineError` if the file can't be read or isn't an object.
    """
    try:
        values = _json_of(_text_of(path), path)
    except ValueError as error:
        raise EngineError(f"{path} isn't valid JSON: {error}. Write one object") from None
    if not isinstance(values, dict):
        raise EngineError(f"{path} must hold one object, got {type(values).__name__}")
    return values


def _text_of(path: Path) -> str:
    try:
        return read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        raise EngineError(f"{path} can't be read: {error}") from None


def _json_of(text: str, path: Path) -> Any:
    """Return the values in a JSON text.

    Raises `ValueError` if the text isn't JSON, or nested too deeply; `EngineError` if an object has
    a key twice, because JSON readers don't agree on which of the two values is valid.
    """

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                said = f"{path}: `{key:.80}` must be given once in an object, got it twice"
                raise EngineError(storable(f"{said}. Remove one"))
            seen.add(key)
        return dict(pairs)

    try:
        values = json.loads(text, object_pairs_hook=once)
        if "\\u" in text:  # it may contain half of a surrogate pair, which can't be stored
            json.dumps(values, ensure_ascii=False).encode()
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    return values


def recorded_engine(run: EngineAnswer) -> ReferenceEngine:
    """Return an engine that can only return a run made outside Ghostball."""

    class EngineOfRun(_RecordedEngine):
        name: ClassVar[str] = run.engine

    return EngineOfRun(run)


class _RecordedEngine(EngineBase):
    def __init__(self, run: EngineAnswer) -> None:
        super().__init__()
        self._run = run

    @property
    def capabilities(self) -> Capabilities:
        """All features: approximate if the run says so, otherwise exact."""
        said = {one: Capability("approximate", how) for one, how in self._run.approximate.items()}
        return dict.fromkeys(Feature, EXACT) | said

    def resolution(self, scene: Scene) -> float | None:  # noqa: ARG002
        """Return the resolution that the run declares [m]; None if it declares none."""
        return self._run.resolution

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Return the run."""
        return self._run.result(scene, record=record)
