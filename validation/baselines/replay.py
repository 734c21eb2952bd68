"""Whether an engine is deterministic: plays a shot again, and compares the bits.

A baseline is what an engine did, to the bit. Of one that does something else each time that says
nothing, so that whatever differs from its baseline is played twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ghostball.model import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.model.hashes import bits_hash
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.validation.runs.playing import in_other_process, run_engine
from ghostball.validation.runs.sampling import events_of

PlayAgain = Callable[[Scene], str]
"""Plays a shot, and returns the hash of its bits, or why there is none."""


@contextmanager
def playing_again(label: str, time_limit: float | None = None) -> Iterator[PlayAgain]:
    """Yield what plays a shot on an engine again; nothing is started before it is called.

    `label`: the engine, as it was asked for.
    `time_limit` [s]: for each shot, of an engine other than ours; see
        `runs.playing.in_other_process`.
    """
    with in_other_process(make_engine(label), time_limit) as engine:

        def play(scene: Scene) -> str:
            try:
                result = run_engine(engine, scene)
            except (EngineFailedError, EngineUnavailableError, UnsupportedSceneError) as error:
                return f"it failed: {error}"
            return bits_hash(events_of(result), result.rest_positions)

        yield play
