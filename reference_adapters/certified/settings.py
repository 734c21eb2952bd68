"""Settings that limit a proof."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ghostball.reference_adapters.base import EngineSettings


class CertifiedSettings(EngineSettings):
    """Settings of `CertifiedEngine`.

    `start_precision`: initial precision, doubled until everything is proved [bits].
    `max_precision`: largest precision [bits].
    `max_events`: number of events after which the proof ends.
    `time_limit`: computing time after which the proof ends [s]; such a certificate isn't stored.
    `width`: largest width of the final enclosure of a position [m], a time [s] and a speed [m/s].
        The default is a hundredth of the rounding of a coordinate on a table.
    """

    start_precision: Annotated[int, Field(ge=24, le=2**20)] = 53
    max_precision: Annotated[int, Field(ge=24, le=2**20)] = 53 * 2**6
    max_events: Annotated[int, Field(gt=0)] = 100_000
    time_limit: Annotated[float, Field(gt=0.0)] = 600.0
    width: Annotated[float, Field(gt=0.0)] = 1e-18
