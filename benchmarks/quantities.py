"""The quantities that workloads measure, each with its unit and what it means."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Quantity(NamedTuple):
    """The unit of a quantity, and what it means in words."""

    unit: str
    meaning: str


QUANTITIES: Mapping[str, Quantity] = {
    "kernel": Quantity("s", "the simulation alone"),
    "kernel_mean": Quantity("s", "the same, mean over the scenes"),
    "kernel_p99": Quantity("s", "the same, 99 % of the scenes take no longer"),
    "kernel_slowest": Quantity("s", "the same of the slowest scene"),
    "call": Quantity("s", "the whole call of simulate()"),
    "call_extra": Quantity("s", "the whole call, over that"),
    "first_call_extra": Quantity("s", "the same of a scene that is run for the first time"),
    "free_call_extra": Quantity(
        "s", "the whole call over the simulation, shots without contact steps"
    ),
    "contact_call_extra": Quantity("s", "the same, shots with contact steps"),
    "per_event": Quantity("s", "the simulation alone, per event"),
    "free_per_event": Quantity(
        "s", "the simulation alone, per event, shots without contact steps or joint impacts"
    ),
    "per_contact_step": Quantity("s", "the simulation alone, per contact step"),
    "per_joint_impact": Quantity("s", "the simulation alone, per joint impact"),
    "events_extra": Quantity("1", 'what record="events" adds to it, a part of it'),
    "collisions_per_second": Quantity("1/s", "impacts of two balls in a second"),
    "bytes_per_ball": Quantity("B", "arrays of the kernels, per ball"),
    "shots_per_second": Quantity("1/s", "shots in a second, one thread"),
    "two_threads": Quantity("1", "shots in a second, two threads over one"),
    "first_shot": Quantity("s", "from the start of the process to the end of a shot"),
    "every_variant": Quantity(
        "s", "what `make validate` needs of the kernels, compiled in two processes"
    ),
    "import": Quantity("s", "`import ghostball.engine` in a new process"),
}
"""By the name that rows have."""
