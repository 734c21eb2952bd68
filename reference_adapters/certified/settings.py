"""How far a proof may go."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ghostball.reference_adapters.base import EngineSettings


class CertifiedSettings(EngineSettings):
    """Settings of `CertifiedEngine`.

    Attributes
    ----------
    start_precision : int [bits]
        The precision to begin with; it is doubled until everything is proved.
    max_precision : int [bits]
        The cap: the precision is never above.
    max_events : int
        Events after which to stop.
    time_limit : float [s]
        Computing time after which to stop; what was stopped so isn't kept for later.
    width : float [m]
        How wide the enclosure of a position may be at the end; in s and m/s, that of an instant and
        of a speed. The default is a hundredth of the rounding of a double on a table.
    """

    start_precision: Annotated[int, Field(ge=24, le=2**20)] = 53
    max_precision: Annotated[int, Field(ge=24, le=2**20)] = 53 * 2**6
    max_events: Annotated[int, Field(gt=0)] = 100_000
    time_limit: Annotated[float, Field(gt=0.0)] = 600.0
    width: Annotated[float, Field(gt=0.0)] = 1e-18
