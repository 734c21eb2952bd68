"""What Bullet's steps tell of, whether balls roll in the plane or slide in space."""

from __future__ import annotations

from typing import ClassVar

from ghostball.model import EventKind, Samples
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping.plane import Collision, Stepper


class BulletSteps(Stepper):
    """Steps whose collisions Bullet sees, and changes velocities for, as they begin.

    So a recorded motion turns there: by the places that the new velocities would have come from.
    Balls that only roll stop within a step, where the closed form says.

    `rest_time`: when the last ball stopped so far [s].
    """

    CONTACTS: ClassVar[str] = "contacts"
    KEEPS_START: ClassVar[bool] = False

    rest_time = 0.0
    _around: tuple[Samples, ...] = ()
    """The states just before and just after the collisions of the last step."""
    _notes: list[tuple[float, EventKind, int, int]]
    """What else happened in it, but for falls: when [s], what, to which ball, and where or -1."""

    def tell(self, recorder: Recorder, started: float, _: Samples | None) -> None:
        """Hand what happened in the last step to a recorder."""
        self._tell_of_collisions(recorder)
        for state in self._around:
            self.keep(recorder, started, state)
        self._tell_of_falls(recorder, started)
        for note in self._notes:
            recorder.event(*note)
        # The last ball may have come to rest within the step: then the end is before `t`, and the
        # recorder's last frame is of there.
        if recorder.wants_frame(self.t) and not self.at_rest:
            self.record(recorder)

    def _take_collisions(self, found: list[Collision], positions: FloatArray) -> None:
        super()._take_collisions(found, positions)
        self.collisions.sort(key=lambda one: (one.cushion, one.a, one.b))

    def _note_rest(self, t: float) -> None:
        """Note that a ball has stopped at an instant [s]."""
        self.rest_time = max(self.rest_time, t)
