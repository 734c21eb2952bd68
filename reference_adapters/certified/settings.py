"""How far a proof may go."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ghostball.reference_adapters.base import EngineSettings


class CertifiedSettings(EngineSettings):
    """Settings of `CertifiedEngine`.

    `start_precision` [bits]: the precision to begin with; it is doubled until everything is proved.
    `max_precision` [bits]: the cap: the precision is never above.
    `max_events`: events after which to stop.
    `time_limit` [s]: computing time after which to stop; what was stopped so isn't kept for later.
    `width` [m]: how wide the enclosure of a position may be at the end; in s and m/s, that of an
        instant and of a speed. The default is a hundredth of the rounding of a double on a table.
    """

    start_precision: Annotated[int, Field(ge=24, le=2**20)] = 53
    max_precision: Annotated[int, Field(ge=24, le=2**20)] = 53 * 2**6
    max_events: Annotated[int, Field(gt=0)] = 100_000
    time_limit: Annotated[float, Field(gt=0.0)] = 600.0
    width: Annotated[float, Field(gt=0.0)] = 1e-18
