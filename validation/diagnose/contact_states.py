"""Compare the motion of an engine's balls just after a contact with the scene's impact law.

    >>> fault_at_contacts(result)
    ContactFault(what='energy', kind=<EventKind.BALL_BALL: 0>, count=12, measured=1.02, right=1.0)

Each contact is judged from the engine's own state just before it: Ghostball's engine simulates the
same few milliseconds from that state, including the cloth. A contact can therefore be judged even
if the collisions differ from the reference. Contacts that share a ball within these milliseconds
are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from ghostball.model import (
    EventKind,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    SceneError,
    energy_of,
)
from ghostball.validation.diagnose.margins import ball_at
from ghostball.validation.grading.event_logs import Event, events_in
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.sampling import events_of

MOST_CONTACTS: Final = 40
"""Number of contacts of each kind that are examined: the first ones in the run."""

SAMPLE_OFFSET: Final = 1e-6
"""Time before and after a contact at which an exact motion is sampled [s]."""

FRAMES_AFTER: Final = 1
"""Frames skipped after a contact: an engine may report it before the velocities change."""

LONGEST_INTERVAL: Final = 0.05
"""Longest interval around a contact [s]; a longer one includes more than the contact."""

ENERGY_ERROR: Final = 0.003
"""Smallest error of an energy change that counts, as a share of the energy."""

VELOCITY_ERROR: Final = 0.02
"""Smallest error of a velocity that counts, as a share of the speed."""

FAULTY_SHARE: Final = 0.7
"""Share of contacts that must show a fault: a single contact may be a graze, or detected late."""

WATCHED_TIME: Final = 0.02
"""Time after a contact over which the acceleration is measured [s]: a slide lasts longer."""

SLIDING_SHARE: Final = 0.5
"""A ball counts as sliding above this share of the deceleration of a sliding ball."""

Fault = Literal["energy", "slide", "velocity"]


@dataclass(frozen=True)
class ContactFault:
    """An error that most contacts of one kind show.

    `what`: "energy": the energy of the balls after a contact divided by that before; "slide": the
        acceleration of a ball that should roll after a contact [m/s^2]; "velocity": the error of a
        velocity after a contact, divided by the largest speed before.
    `kind`: kind of the contacts; `count`: number of examined contacts.
    `measured`, `right`: medians over the contacts.
    """

    what: Fault
    kind: EventKind
    count: int
    measured: float
    right: float

    @property
    def gains_energy(self) -> bool:
        """Whether the balls gain energy in these contacts."""
        return self.what == "energy" and self.measured > 1.0 + ENERGY_ERROR


@dataclass(frozen=True)
class _Contact:
    """A contact: the changes in the run, and those by the scene's impact law from the same state.

    `energy` [1]: energy of the balls after the contact divided by that before; `right`: by the law.
    `error` [1]: error of a velocity, divided by `speed`, the largest speed before [m/s].
    `window` [s]: time from the state before to the state after, with friction of the cloth.
    `pull` [m/s^2]: mean acceleration of the ball that accelerates most afterwards; None if another
        event follows too soon.
    """

    kind: EventKind
    energy: float
    right: float
    error: float
    speed: float
    window: float
    pull: float | None


def fault_at_contacts(result: Result) -> ContactFault | None:
    """Return the most serious fault that most contacts of one kind show; None if there is none.

    `result`: with its events and its motion.
    """
    contacts = list(_contacts(result))
    # The deceleration before any contact: a wrong rolling friction must not count as a slide.
    first = min((float(one.t) for one in events_in(events_of(result))), default=WATCHED_TIME)
    slows = (
        _pull(result, list(range(len(result.scene.balls))), 0.0, min(first, WATCHED_TIME)) or 0.0
    )
    found = [
        fault
        for kind in (EventKind.BALL_BALL, EventKind.BALL_CUSHION)
        for fault in _faults(result.scene, [one for one in contacts if one.kind is kind], slows)
    ]
    order: Sequence[Fault] = ("slide", "energy", "velocity")
    return min(found, key=lambda one: (order.index(one.what), one.kind), default=None)


def _faults(scene: Scene, contacts: Sequence[_Contact], slows: float) -> Iterator[ContactFault]:
    """Yield the faults that most contacts of a kind show; `slows`: earlier deceleration [m/s^2]."""
    if not contacts:
        return
    kind, count = contacts[0].kind, len(contacts)
    pulls = np.array([one.pull for one in contacts if one.pull is not None])
    physics = scene.physics
    slides, rolls = (
        physics.gravity * one for one in (physics.sliding_friction, physics.rolling_friction)
    )
    if physics.motion == "rolling" and len(pulls):
        least = max(SLIDING_SHARE * slides, 2.0 * rolls, 2.0 * slows)
        if np.mean(pulls > least) >= FAULTY_SHARE:
            yield ContactFault("slide", kind, len(pulls), float(np.median(pulls)), rolls)
    columns = [(one.energy, one.right, one.error, one.speed, one.window) for one in contacts]
    energies, right, errors, speeds, windows = np.array(columns).T
    # A wrong friction of the cloth changes speeds by this share around a contact.
    cloth = np.abs(slows - rolls) * windows / speeds if slows > 0.0 else np.zeros(count)
    wrong = energies - right
    alike = np.mean(wrong * np.sign(np.median(wrong)) > ENERGY_ERROR + 2.0 * cloth)
    if alike >= FAULTY_SHARE:
        yield ContactFault(
            "energy", kind, count, float(np.median(energies)), float(np.median(right))
        )
    if np.mean(errors > VELOCITY_ERROR + cloth) >= FAULTY_SHARE:
        yield ContactFault("velocity", kind, count, float(np.median(errors)), 0.0)


def _contacts(result: Result) -> Iterator[_Contact]:
    """Yield the isolated contacts of a run, each compared with the scene's impact law."""
    everything = events_in(events_of(result), tuple(EventKind))
    seen = {EventKind.BALL_BALL: 0, EventKind.BALL_CUSHION: 0}
    for one in everything:
        if one.kind not in seen or seen[one.kind] >= MOST_CONTACTS:
            continue
        start, end = _window(result, one.t)
        balls = list(one.balls)
        others = [two.t for two in everything if two is not one and set(two.balls) & set(balls)]
        if end - start > LONGEST_INTERVAL or any(start <= t <= end for t in others):
            continue
        states = result.sample([start, end])
        played = _by_the_law(result.scene, one, states, start, end)
        if played is None:
            continue
        seen[one.kind] += 1
        speed = float(np.max(np.linalg.norm(states.velocities[0, balls], axis=1)))
        error = np.linalg.norm(
            states.velocities[1, balls] - played.final_state.velocities[0], axis=1
        )
        later = min((t for t in others if t > end), default=math.inf)
        t = float(events_in(events_of(played))[0].t)
        at_contact = played.energy([max(float(np.nextafter(t, 0.0)), 0.0), t]).total
        mine = Samples(*(part[:, balls] for part in states))
        before, after = energy_of(played.scene, mine).total
        by_the_law = played.energy([played.rest_time]).total[0]
        right = float(at_contact[1] / at_contact[0]) if t > 0.0 else float(by_the_law / before)
        yield _Contact(
            one.kind,
            right + float(after - by_the_law) / float(before),
            right,
            float(np.max(error)) / speed,
            speed,
            end - start,
            _pull(result, balls, end, min(later, end + WATCHED_TIME)),
        )


def _window(result: Result, t: float) -> tuple[float, float]:
    """Return the times just before and just after a contact [s]."""
    frames = result.trajectory
    if not isinstance(frames, SampledTrajectory):
        return max(t - SAMPLE_OFFSET, 0.0), t + SAMPLE_OFFSET
    times = frames.times
    before = max(int(np.searchsorted(times, t, side="left")) - 1, 0)
    after = min(int(np.searchsorted(times, t, side="left")) + FRAMES_AFTER, len(times) - 1)
    return float(times[before]), float(times[after])


def _by_the_law(
    scene: Scene, one: Event, states: Samples, start: float, end: float
) -> Result | None:
    """Simulate a contact from the state before it; None unless its balls collide exactly once."""
    try:
        shot = Scene(
            name="contact",
            physics=scene.physics,
            table=scene.table,
            balls=[ball_at(scene, states, index) for index in one.balls],
            t_max=end - start,
        )
    except SceneError:  # in the engine's state, balls overlap
        return None
    played = run_ours(shot)
    met = [two.kind for two in events_in(events_of(played))]
    if met != [one.kind] or not played.status.complete:
        return None
    return played


def _pull(result: Result, balls: list[int], start: float, end: float) -> float | None:
    """Return the largest mean acceleration of a ball between two times [m/s^2]."""
    end = min(end, result.rest_time)
    if not end - start > 0.25 * WATCHED_TIME:
        return None
    # The interval ends before the next event: frames average velocities before and after events.
    first, last = result.sample([start, end - 0.1 * (end - start)]).velocities[:, balls]
    return float(np.max(np.linalg.norm(last - first, axis=1)) / (0.9 * (end - start)))
