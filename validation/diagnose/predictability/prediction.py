"""What is known of how far a shot can be predicted, and where a results folder keeps it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter

from ghostball.engine.scene.fields import SceneName
from ghostball.validation.results.database import has_database, reading, record_of
from ghostball.validation.results.fields import FloatArray, check_shape
from ghostball.validation.results.record_store import Name, RecordStore
from ghostball.validation.results.records import definition_hash
from ghostball.validation.results.store import Results


@dataclass(frozen=True, eq=False)
class Separation:
    """How far apart two shots come that begin almost alike, and what the tangent map says of it.

    Attributes
    ----------
    size : float [m/s]
        What the second shot's fastest ball is faster by at the start.
    apart : (k,) float64 [m]
        The largest distance of a ball in one shot from where it is in the other, at
        `Predictability.times`.
    predicted : (k,) float64 [m]
        That by the tangent map of the first shot; nan where no derivative exists.
    """

    size: float
    apart: FloatArray
    predicted: FloatArray

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)


@dataclass(frozen=True, eq=False)
class Predictability:
    """How far a shot can be predicted.

    Attributes
    ----------
    scene : str
    rest_time : float [s]
    tolerance : float [m]
    horizon : float [s] or None
        When rounding may exceed the tolerance; None: never.
    ends : str
        What the horizon comes from: "growth" of rounding, or "several collisions at one instant"
        or "sustained contact", past which no derivative exists, or "no derivative in air, or in
        flight"; "" where there is none.
    times : (k,) float64 [s]
    growth : (k,) float64 [m]
        The largest `Result.sensitivity` of a ball; nan where no derivative exists.
    separations : tuple of Separation
        Of a scene with the tag "chaos".
    definition_hash : str
        Of the scene: one of its name may be another.
    """

    scene: SceneName
    rest_time: float
    tolerance: float
    horizon: float | None
    ends: str
    times: FloatArray
    growth: FloatArray
    separations: tuple[Separation, ...] = ()
    definition_hash: str = ""

    __pydantic_config__ = ConfigDict(extra="forbid", arbitrary_types_allowed=True)

    def __post_init__(self) -> None:
        """Refuse curves that have no instants, or other ones."""
        if self.times.ndim != 1 or len(self.times) == 0:
            raise ValueError(f"`times` must be instants, got the shape {self.times.shape}")
        check_shape("growth", self.growth, self.times.shape)
        for separation in self.separations:
            check_shape("apart", separation.apart, self.times.shape)
            check_shape("predicted", separation.predicted, self.times.shape)


_RECORD = TypeAdapter(Predictability)


class PredictionStore(RecordStore[Predictability, Predictability]):
    """Writes how far shots can be predicted, each at once."""

    kind = "prediction"
    adapter = _RECORD
    what = "a prediction"
    others_stay = True

    def name_of(self, record: Predictability) -> Name:
        """Return the scene's name."""
        return (record.scene,)


def load_predictability(folder: Path) -> dict[str, Predictability]:
    """Read what a results folder holds, by scene; nothing where there is none.

    Raises
    ------
    ResultsError
        Where it can't be read.
    """
    if not has_database(folder):
        return {}
    with reading(folder) as database:
        texts = database.execute(
            "SELECT record FROM records WHERE kind = 'prediction' ORDER BY id"
        ).fetchall()
    records = [record_of(_RECORD, text, f"{folder}: a prediction") for (text,) in texts]
    return {record.scene: record for record in records}


def predictability_in(results: Results) -> list[Predictability]:
    """Return what a results folder holds of its very scenes, in their order.

    One of another version of a scene, left by an earlier run, is none of them.

    Raises
    ------
    ResultsError
        As `load_predictability`.
    """
    known = load_predictability(results.path)
    hashes = {case.scene: definition_hash(case.definition) for case in results.cases}
    return [
        known[name]
        for name in results.scene_names
        if name in known and known[name].definition_hash == hashes[name]
    ]
