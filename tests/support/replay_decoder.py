"""Reads what `reports.page.replay_tracks` packed: the page's script again, slow and plain."""

import base64
import struct
import zlib

import numpy as np


class Packed:
    """The bytes of a scene, read from the first to the last."""

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
    """Return for each engine with a motion its event log and its balls' pieces, by label."""
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
            knots = packed.number()
            pieces = max(knots - 1, 0)
            track = {"t": times[packed.sums(knots)], "phases": list(packed.raw(pieces))}
            track["xy"] = np.stack([packed.sums(knots), packed.sums(knots)], axis=1)
            bows = [packed.numbers(pieces), packed.numbers(pieces)]
            track["bow"] = np.array(bows, dtype=np.int64).reshape(2, pieces).T
            tracks.append(track)
        engines[engine["label"]] = (log, tracks)
    assert packed.at == len(packed.bytes)
    return engines


def place_at(track: dict, t: float, quantum: float) -> np.ndarray:
    """Return where a ball is, (2,) [m]."""
    knots = track["t"]
    if t >= knots[-1]:
        return track["xy"][-1] * quantum
    i = int(np.searchsorted(knots, t, side="right")) - 1
    u = (t - knots[i]) / (knots[i + 1] - knots[i])
    first, last = track["xy"][i], track["xy"][i + 1]
    return (first + u * (last - first) + 4 * u * (1 - u) * track["bow"][i]) * quantum
