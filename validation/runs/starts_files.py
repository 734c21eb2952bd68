"""Simulate files of initial states or strokes on Ghostball's engine, in parts and in shards.

A file has one row per shot, as CSV or Parquet. Its columns are those of a stroke, `speed`,
`direction`, `elevation`, `offset_left` and `offset_up`; or states of balls, such as `cue.x` and
`cue.vx` for the ball with the id "cue": x, y, z [m], vx, vy, vz [m/s], wx, wy, wz [rad/s]. The rest
is as in the scene. The struck ball is the one with a `strike` in the scene, else the first.

>>> frame = play_file(scene, Path("strokes.csv"), Shard(7, 64))
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ghostball.engine import Strokes, simulate_starts
from ghostball.model import GhostballError, Scene, rolling_angular_velocity
from ghostball.model.arrays import FloatArray
from ghostball.validation.parallel.pool import Workers

PART = 50_000
"""Number of shots that are simulated at once; a cluster has a task for each part."""

STROKE = ("speed", "direction", "elevation", "offset_left", "offset_up")
_STATE = {"": "positions", "v": "velocities", "w": "angular_velocities"}
_AXES = "xyz"


@dataclass(frozen=True)
class Shard:
    """A share of the shots: part `index` of `count`, from 1."""

    index: int
    count: int

    @classmethod
    def parse(cls, text: str) -> Shard:
        """Return the shard that a text such as "7/64" describes.

        Raises `GhostballError` if there is no such shard.
        """
        index, _, count = text.partition("/")
        if index.isdecimal() and count.isdecimal() and 1 <= int(index) <= int(count):
            return cls(int(index), int(count))
        raise GhostballError(
            f"a shard must be i/n with i from 1 to n, such as 7/64, got {text!r:.40}"
        )

    def of(self, number: int) -> range:
        """Return the indices of the shots in this shard, for a file with `number` shots."""
        bounds = (number * k // self.count for k in (self.index - 1, self.index))
        return range(*bounds)

    def no_shots(self, number: int) -> GhostballError:
        """Return the error if this shard has none of a number of shots."""
        return GhostballError(
            f"shard {self.index}/{self.count} has no shots, because there are {number} in all. Use "
            "fewer shards"
        )

    def file_name(self, rows: str) -> str:
        """Return the name of the shard's file of these rows; names sort in order."""
        return f"{rows}-{self.index:0{len(str(self.count))}}-of-{self.count}.parquet"


class _Part(NamedTuple):
    """Consecutive shots of a file: a task of a cluster."""

    scene: Scene
    first: int
    columns: dict[str, FloatArray]
    threads: int | None


def play_file(
    scene: Scene,
    path: Path,
    shard: Shard,
    *,
    cluster: Workers | None = None,
    progress: Callable[[int, int, str], None] = lambda *_: None,
) -> Any:
    """Simulate the shots in one shard of a file.

    `cluster`: runs the shots; None: all processors of this machine run them.
    `progress`: called with the number of finished shots, the number of all shots, and a text.

    Returns a polars data frame with a row for each shot: `shot`, its index in the file, and the
    columns of `Batch.to_frame`.

    Raises `GhostballError` if the file can't be read, or if a shot can't be simulated; the message
    names the shot.
    """
    polars = _polars()
    table, number = _opened(path, polars)
    names = table.collect_schema().names()
    _check_columns(names, scene, path)
    rows = shard.of(number)
    if not rows:
        raise shard.no_shots(number)
    firsts = range(rows.start, rows.stop, PART)
    given = _columns(table.slice(rows.start, len(rows)).collect(), rows.start, path)

    def parts() -> Iterable[_Part]:
        for first in firsts:
            some = slice(first - rows.start, first - rows.start + PART)
            columns = {name: values[some] for name, values in given.items()}
            yield _Part(scene, first, columns, None if cluster is None else 1)

    frames: dict[int, Any] = {}
    for first, frame in _played(parts(), cluster):
        frames[first] = frame
        progress(sum(map(len, frames.values())), len(rows), f"shot {first}")
    return polars.concat([frames[first] for first in firsts])


def parquet_of(frame: Any) -> bytes:
    """Return a polars data frame as a Parquet file."""
    file = io.BytesIO()
    frame.write_parquet(file)
    return file.getvalue()


def _played(parts: Iterable[_Part], cluster: Workers | None) -> Iterable[tuple[int, Any]]:
    """Yield the first shot and the frame of each part, in any order."""
    if cluster is None:
        yield from ((part.first, _raised(_play(part))) for part in parts)
        return
    for done in cluster.run_tasks(parts, _play):
        if done.crashed:
            raise GhostballError(f"the shots from {done.task.first} on failed: {done.crashed}")
        yield done.task.first, _raised(done.given)


def _play(part: _Part) -> Any:
    """Return the results of a part, or the message of an error, which a cluster would lose."""
    polars = _polars()
    given = part.columns
    try:
        if set(given) <= set(STROKE):
            struck = (k for k, ball in enumerate(part.scene.balls) if ball.strike is not None)
            strokes = Strokes(**given, ball=next(struck, 0))  # type: ignore[arg-type]
            batch = simulate_starts(part.scene, strokes=strokes, threads=part.threads)
        else:
            batch = simulate_starts(part.scene, *_states(part), threads=part.threads)
    except GhostballError as error:
        return f"{error} (shot 0 here is shot {part.first} of the file)"
    shots = polars.Series("shot", np.arange(part.first, part.first + len(batch.status)))
    return batch.to_frame().insert_column(0, shots)


def _raised(found: Any) -> Any:
    if isinstance(found, str):
        raise GhostballError(found)
    return found


def _states(part: _Part) -> Sequence[FloatArray | None]:
    """Return positions, velocities and angular velocities, (k, n, 3) each; None: the scene's."""
    scene, given = part.scene, part.columns
    ids = [ball.id for ball in scene.balls]
    k = len(next(iter(given.values())))
    states: dict[str, FloatArray] = {}
    for prefix, name in _STATE.items():
        values = np.repeat(getattr(scene, name)[np.newaxis], k, axis=0)
        if name == "angular_velocities":  # a ball with a given velocity rolls
            moved = [any(f"{one}.v{axis}" in given for axis in _AXES) for one in ids]
            rolling = rolling_angular_velocity(states["velocities"], scene.radii)
            values[:, moved] = rolling[:, moved]
        for ball, one in enumerate(ids):
            for axis, letter in enumerate(_AXES):
                if (column := f"{one}.{prefix}{letter}") in given:
                    values[:, ball, axis] = given[column]
        states[name] = values
    told = {name.rpartition(".")[2][0] for name in given}
    if told <= set(_AXES):  # positions alone
        return states["positions"], None, None
    if "w" not in told and all(ball.angular_velocity is None for ball in scene.balls):
        return states["positions"], states["velocities"], None
    return tuple(states.values())


def _check_columns(names: Sequence[str], scene: Scene, path: Path) -> None:
    known = {f"{b.id}.{prefix}{axis}" for b in scene.balls for prefix in _STATE for axis in _AXES}
    unknown = [name for name in names if name not in known and name not in STROKE]
    if unknown:
        raise GhostballError(
            f"{path}: `{unknown[0]:.80}` is not a column of starts. Columns: {', '.join(STROKE)}; "
            f"or states of balls, such as {scene.balls[0].id}.x, {scene.balls[0].id}.vx and "
            f"{scene.balls[0].id}.wx"
        )
    strokes = [name for name in names if name in STROKE]
    if strokes and (len(strokes) < len(names) or not {"speed", "direction"} <= set(strokes)):
        raise GhostballError(
            f"{path}: columns of strokes must include speed and direction, and no states, got "
            f"{', '.join(names):.200}"
        )


def _columns(frame: Any, first: int, path: Path) -> dict[str, FloatArray]:
    """Return the columns of some rows as numbers; `first` is the index of the first row."""
    columns = {}
    for series in frame:
        if not (series.dtype.is_numeric() or series.dtype.is_(_polars().Null)):
            row = next((k for k, x in enumerate(series) if not _is_number(x)), 0)
            raise _wrong_value(path, first + row, series.name, series[row])
        values = series.cast(_polars().Float64).fill_null(float("nan")).to_numpy()
        for row in np.flatnonzero(~np.isfinite(values))[:1].tolist():
            raise _wrong_value(path, first + row, series.name, series[row])
        columns[series.name] = values
    return columns


def _is_number(text: Any) -> bool:
    try:
        float(text)
    except (TypeError, ValueError):
        return False
    return True


def _wrong_value(path: Path, shot: int, name: str, value: object) -> GhostballError:
    return GhostballError(
        f"{path}: `{name}` of shot {shot} must be a finite number, got {value!r:.40}"
    )


def _opened(path: Path, polars: Any) -> tuple[Any, int]:
    """Return a file as a lazy table, and its number of rows."""
    readers = {".csv": polars.scan_csv, ".parquet": polars.scan_parquet}
    if path.suffix not in readers:
        raise GhostballError(f"{path} must be a .csv or .parquet file of starts")
    try:
        # Types are found from all rows, because a shard may start at any row.
        more = {"infer_schema_length": None} if path.suffix == ".csv" else {}
        table = readers[path.suffix](path, **more)
        return table, table.select(polars.len()).collect().item()
    except (OSError, polars.exceptions.PolarsError) as error:
        why = str(error).partition("\n")[0]
        raise GhostballError(f"{path} can't be read as a table of starts: {why}") from None


def _polars() -> Any:
    try:
        import polars  # noqa: PLC0415 - an optional dependency
    except ImportError:
        raise GhostballError(
            "files of starts need polars, which isn't installed. Install it with `pip install "
            "'.[frames]'` in a clone of Ghostball"
        ) from None
    return polars
