"""A simple decoder for the data of `reports.page.replay_tracks`."""

import base64
import struct
import zlib

import numpy as np

from ghostball.model.trajectory.orientation import hamilton_product


class Packed:
    """The bytes of a scene, read in order."""

    def __init__(self, text: str) -> None:
        self.bytes = zlib.decompress(base64.b64decode(text), -15)
        self.at = 0

    def number(self) -> int:
        folded = weight = 0
        while True:
            byte = self.bytes[self.at]
            self.at += 1
            folded |= (byte & 127) << weight
            weight += 7
            if byte < 128:
                return -((folded + 1) >> 1) if folded & 1 else folded >> 1

    def numbers(self, count: int) -> list[int]:
        return [self.number() for _ in range(count)]

    def sums(self, count: int) -> np.ndarray:
        return np.cumsum(self.numbers(count), dtype=np.int64)

    def raw(self, count: int) -> bytes:
        self.at += count
        return self.bytes[self.at - count : self.at]

    def doubles(self, count: int) -> list[float]:
        planes = self.raw(8 * count)
        return [struct.unpack("<d", planes[i::count])[0] for i in range(count)]


def decoded(data: dict) -> dict:
    """Return the event log and the pieces of all balls, for each engine with a motion, by label."""
    packed = Packed(data["packed"])
    engines = {}
    for engine in data["engines"]:
        if engine["motion"] is None:
            continue
        count = packed.number()
        log = (
            packed.doubles(count),
            list(packed.raw(count)),
            packed.sums(count).tolist(),
            packed.sums(count).tolist(),
        )
        times = packed.sums(packed.number()) * engine["motion"]["tick"]
        tracks = []
        for _ in data["balls"]:
            points = packed.number()
            pieces = max(points - 1, 0)
            track = {"t": times[packed.sums(points)], "phases": list(packed.raw(pieces))}
            track["xyz"] = np.stack([packed.sums(points) for _ in range(3)], axis=1)
            for name, count in (("bow", 3), ("spin", 6)):
                rows = [packed.numbers(pieces) for _ in range(count)]
                track[name] = np.array(rows, dtype=np.int64).reshape(count, pieces).T
            tracks.append(track)
        engines[engine["label"]] = (log, tracks)
    assert packed.at == len(packed.bytes)
    return engines


def place_at(track: dict, t: float, quantum: float) -> np.ndarray:
    """Return the position of a ball at time t, (3,) [m]."""
    times = track["t"]
    if t >= times[-1]:
        return track["xyz"][-1] * quantum
    i = int(np.searchsorted(times, t, side="right")) - 1
    u = (t - times[i]) / (times[i + 1] - times[i])
    first, last = track["xyz"][i], track["xyz"][i + 1]
    return (first + u * (last - first) + 4 * u * (1 - u) * track["bow"][i]) * quantum


def turned_by(data: dict, track: dict, radius: float) -> np.ndarray:
    """Return the orientation at the end of a track, a unit quaternion (4,), from small steps."""
    now = np.array([1.0, 0.0, 0.0, 0.0])
    along = np.diff(track["xyz"], axis=0)
    for i, dt in enumerate(np.diff(track["t"])):
        if dt <= 0.0:
            continue
        spins = []
        for sign, more in ((1, track["spin"][i, :3]), (-1, track["spin"][i, 3:])):
            vx, vy, _ = (along[i] + sign * 4 * track["bow"][i]) * data["quantum"] / dt
            spins.append(np.array([-vy, vx, 0.0]) / radius + more * data["spin"])
        steps = 1 + int(20.0 * dt * np.linalg.norm(spins, axis=1).max())
        for k in range(steps):
            w = spins[0] + (k + 0.5) / steps * (spins[1] - spins[0])
            half = 0.5 * dt / steps * w
            size = np.linalg.norm(half)
            turn = np.concatenate(([np.cos(size)], np.sinc(size / np.pi) * half))
            now = hamilton_product(turn, now)
    return now
