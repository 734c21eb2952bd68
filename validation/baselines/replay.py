"""Whether an engine is deterministic: plays a shot again, and compares the bits.

A baseline is what an engine did, to the bit, and a band around it. Of one that does something else
each time neither says anything, so that whatever differs from its baseline is played twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ghostball.model import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.model.hashes import bits_hash
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.validation.baselines.observed import Observed
from ghostball.validation.baselines.regression import SceneChange
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


def not_deterministic(
    head: Observed, base_bits: str, play_again: PlayAgain, scene: Scene, command: str
) -> SceneChange | None:
    """Return that an engine gives other bits each time it plays a shot; None where it doesn't.

    `head`: what it did.
    `base_bits`: hash of what was accepted, "" where nothing was. Where that is what it did, it
        isn't played again: it did so twice.
    `command`: what shows the scene again, for the record.
    """
    if head.bits == base_bits or (again := play_again(scene)) == head.bits:
        return None
    how = again if again.startswith("it failed") else "it gave other bits"
    return SceneChange(
        scene=head.scene,
        title=head.title,
        change="not-deterministic",
        failed=True,
        summary=f"played a second time, {how}, so that nothing can be compared or accepted. Seed "
        "what is random, and read nothing before it is written",
        command=command,
        base_hash=base_bits,
        head_hash=head.bits,
    )
