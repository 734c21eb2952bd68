"""The agreement of an engine with measurements on real tables, with its best settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import chain
from typing import Any, Final, NamedTuple

import numpy as np

from ghostball.model import EngineFailedError, Physics, Result, Scene, UnsupportedSceneError
from ghostball.model.features import Feature, check_supported, has_feature
from ghostball.reference_adapters import ReferenceEngine, make_engine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.measured.banks import through_points
from ghostball.validation.measured.best_settings import best_cloth, best_cushion, carom_cloth
from ghostball.validation.measured.breaks import (
    BreakCounts,
    break_physics,
    count_breaks,
    setup_of,
    starts_of,
    values_of,
)
from ghostball.validation.measured.facts import FactRow, binomial_error, facts_of
from ghostball.validation.measured.figures import (
    ComparedFigure,
    FigureFamily,
    TableAgreement,
    families_in,
)
from ghostball.validation.measured.hit_formulas import (
    directions_after_hit,
    speeds_after_head_on_hit,
    uncertainty,
)
from ghostball.validation.measured.oblique_hits import (
    head_on_hit,
    oblique_hit,
    passed_throw,
    throw_angle,
)
from ghostball.validation.measured.rebounds import rebounds, square_rebound
from ghostball.validation.measured.rolling import deceleration
from ghostball.validation.measured.simulated_ball import POOL_BALL, OperatorError, Play
from ghostball.validation.measured.spinning import decelerations

__all__ = [
    "MEASUREMENTS",
    "ComparedFigure",
    "FigureFamily",
    "TableAgreement",
    "agreement_with_tables",
    "families_of",
]

ANGLES: Final = (5.0, 45.0)
"""Angles from the normal [degrees]; the measured ratio hardly depends on the angle."""

CUTS: Final = (20.0, 40.0, 60.0)
"""Cuts at which directions after hits are compared [degrees]."""

SPEED_OF_HITS: Final = 0.75
"""Speed of the balls of Domenech 2008 [m/s]."""

SMALL_GAP: Final = 1e-4
"""Gap between two balls that nearly touch [m]."""

BREAKS: Final = 200
"""Number of simulated breaks of a setup; the standard error of a share of 80 % is 2.8 %."""

Settings = Mapping[str, Any]
"""Fields of the physics."""

Rows = Sequence[FactRow]

Figures = Iterator[Iterable[ComparedFigure]]
"""The figures of each family, in the order of the facts."""


class MeasuredEngine(NamedTuple):
    """An engine, and a function that simulates a scene on it and records the motion."""

    engine: ReferenceEngine
    play: Play

    def cushion(self, facts: str) -> Settings | None:
        """Return the best cushion law for some facts, with its coefficients; or None."""
        return best_cushion(facts, self.engine.name, self.engine.capabilities)

    def any_cushion(self, facts: str) -> Settings:
        """Return any cushion law of the engine, for scenes without cushion contacts."""
        return self.cushion(facts) or {"cushion": "mirror"}


def agreement_with_tables(label: str, engine: ReferenceEngine, play: Play) -> TableAgreement:
    """Return the agreement of an engine with measurements on real tables.

    `play` simulates a scene on it, and records the motion. It is never called with a scene that the
    engine doesn't support, so that no process starts for such a scene.
    """

    def checked(scene: Scene) -> Result:
        check_supported(engine.name, engine.capabilities, scene)
        return play(scene)

    player = MeasuredEngine(engine, checked)
    families = chain.from_iterable(families_of(name, player) for name in MEASUREMENTS)
    return TableAgreement(label=label, families=tuple(families))


def families_of(name: str, player: MeasuredEngine) -> list[FigureFamily]:
    """Return the families of a measurement with the engine's values, or the reason for none."""
    facts, (settings_of, figures_of) = facts_of(name), MEASUREMENTS[name]
    families, settings, failed = families_in(facts), settings_of(player), False
    if settings is None:
        return [one.lacking("it has no cushion law that changes spin") for one in families]
    try:
        played = [tuple(figures) for figures in figures_of(player, settings, facts.rows)]
        return [
            one.model_copy(update={"figures": figures, "settings": dict(settings)})
            for one, figures in zip(families, played, strict=True)
        ]
    except UnsupportedSceneError as error:
        why = f"it has {'; '.join(error.features)}"
    except EngineFailedError as error:
        why, failed = f"it failed: {error.reason}", True
    except OperatorError as error:
        why = str(error)
    return [one.lacking(why, failed=failed) for one in families]


def _carom_rebounds(player: MeasuredEngine, cushion: Settings, _rows: Rows) -> Figures:
    """Yield the rebounds of a match of three-cushion billiards, and their dependence on speed."""
    cloth = carom_cloth(player.engine.capabilities)
    physics = Physics(preset="carom", **{**cloth, **cushion})
    ratios = [rebounds(player.play, physics, degrees) for degrees in ANGLES]
    yield chain.from_iterable(ratios)
    yield map(_slope, ratios)


def _slope(figures: Sequence[ComparedFigure]) -> ComparedFigure:
    """Return the slope of measured and of simulated figures, by the same weighted least squares."""
    at, value, error, played = np.array(
        [(one.at, one.value, one.error, one.played) for one in figures]
    ).T
    slopes, covariance = np.polyfit(at, value, 1, w=1.0 / error, cov="unscaled")
    return ComparedFigure(
        at=float(np.mean(at)),
        value=float(slopes[0]),
        error=float(np.sqrt(covariance[0, 0])),
        played=float(np.polyfit(at, played, 1, w=1.0 / error)[0]),
    )


def _pool_rolling(player: MeasuredEngine, cloth: Settings, rows: Rows) -> Figures:
    """Yield the deceleration of cue balls on the cloth of nine-ball matches."""
    physics = Physics(motion="sliding", **cloth, **(player.cushion("cushion-carom") or {}))
    yield [ComparedFigure.of(row, deceleration(player.play, physics, row.place)) for row in rows]


def _banks(player: MeasuredEngine, cushion: Settings, rows: Rows) -> Figures:
    """Yield the banks of sliding balls, measured on five pool tables."""
    physics = Physics(preset="pool", **cushion)
    yield map(
        ComparedFigure.of, rows, through_points(player.play, physics, [row.place for row in rows])
    )


def _snooker_rebounds(player: MeasuredEngine, cushion: Settings, rows: Rows) -> Figures:
    """Yield the perpendicular rebounds on a snooker table."""
    physics = Physics(preset="snooker", **cushion)
    contacts = [square_rebound(player.play, physics, row.place) for row in rows]
    yield [
        ComparedFigure.of(row, contact.normal_ratio * row.place)
        for row, contact in zip(rows, contacts, strict=True)
    ]


def _oblique_hits(player: MeasuredEngine, _settings: Settings, rows: Rows) -> Figures:
    """Yield the speeds after five hits of snooker balls, and the direction of the cue ball.

    Speeds are divided by that before the hit, so that hits of all speeds can be compared.
    """
    physics = Physics(preset="snooker", **player.any_cushion("cushion-snooker"))
    speeds, angles = [], []
    for row in rows:
        before = row.given["speed"]
        hit = oblique_hit(player.play, physics, before, row.place)
        for what, value, played in (
            ("cue ball", row.value, hit.cue_speed),
            ("object ball", row.also["object_speed"], hit.object_speed),
        ):
            speeds.append(_without_error(row, value / before, played / before, what))
        angles.append(_without_error(row, row.also["cue_angle"], hit.cue_angle))
    yield speeds
    yield angles


def _hits_of_materials(player: MeasuredEngine, _settings: Settings, rows: Rows) -> Figures:
    """Yield the directions of the cue ball, and the throw, of each material."""
    cushion = player.any_cushion("banks-pool")
    found = [
        material_hits(player.play, Physics(motion="sliding", **_of_row(row), **cushion), row)
        for row in rows
    ]
    for which in (0, 1):
        yield [hit[which] for hits in found for hit in hits]


def material_hits(
    play: Play, physics: Physics, row: FactRow
) -> list[tuple[ComparedFigure, ComparedFigure]]:
    """Return the direction of the cue ball and the throw at each of `CUTS`, of one material."""
    inputs, errors = (row.value, row.place), (row.error or 0.0, row.given["friction_error"])
    figures = []
    for cut in CUTS:
        formula = partial(directions_after_hit, cut=cut)
        hit = oblique_hit(play, physics, SPEED_OF_HITS, cut, POOL_BALL)
        cue, throw = (
            ComparedFigure(at=cut, value=value, error=error, played=played, what=row.what)
            for value, error, played in zip(
                formula(*inputs).tolist(),
                uncertainty(formula, inputs, errors).tolist(),
                (hit.cue_angle, cut - hit.object_angle),
                strict=True,
            )
        )
        figures.append((cue, throw))
    return figures


def _of_row(row: FactRow) -> dict[str, float]:
    """Return the measured coefficients of two balls as fields of the physics."""
    return {"ball_restitution": row.value, "ball_friction": row.place}


def _head_on_hits(player: MeasuredEngine, _settings: Settings, rows: Rows) -> Figures:
    """Yield the speeds of two balls of different masses right after a head-on hit."""
    figures = []
    for row in rows:
        restitution = {"ball_restitution": row.value}
        physics = Physics(motion="sliding", **restitution, **player.any_cushion("banks-pool"))
        formula = partial(speeds_after_head_on_hit, mass_ratio=row.place)
        speeds = head_on_hit(player.play, physics, SPEED_OF_HITS, row.place)
        errors = uncertainty(formula, (row.value,), (row.error or 0.0,))
        figures += [
            ComparedFigure(
                at=row.place, value=value, error=error, played=speed / SPEED_OF_HITS, what=ball
            )
            for ball, value, error, speed in zip(
                ("hitting ball", "other ball"),
                formula(row.value).tolist(),
                errors.tolist(),
                speeds,
                strict=True,
            )
        ]
    yield figures


def _as_measured(*names: str) -> Settings:
    """Return fields of the physics whose values are those of each row."""
    return dict.fromkeys(names, "as measured")


def _throws(player: MeasuredEngine, balls: Settings, rows: Rows) -> Figures:
    """Yield the throw in cuts of balls without spin."""
    physics = Physics(motion="sliding", **balls, **player.any_cushion("banks-pool"))
    yield [
        _without_error(
            row, value, throw_angle(player.play, physics, row.place, cut), f"cut of {cut:g} degrees"
        )
        for row in rows
        for cut, value in ((30.0, row.value), (45.0, row.also["at_45_degrees"]))
    ]


def _frozen_throws(player: MeasuredEngine, balls: Settings, rows: Rows) -> Figures:
    """Yield the throw of a ball that touches the hit ball, or has a small gap to it."""
    physics = Physics(motion="sliding", **balls, **player.any_cushion("banks-pool"))
    yield [
        _without_error(
            row, value, passed_throw(player.play, physics, 1.0, row.place, gap), f"{what} balls"
        )
        for row in rows
        for what, value, gap in (("frozen", row.value, 0.0), ("near", row.also["gap"], SMALL_GAP))
    ]


def _golf_spin(player: MeasuredEngine, cloth: Settings, rows: Rows) -> Figures:
    """Yield the deceleration of the spin of a golf ball, on the spot and in motion."""
    physics = Physics(motion="sliding", **cloth)
    yield [
        ComparedFigure.of(
            row, decelerations(player.play, physics, spins=True, rolls=row.place > 0.0)[1]
        )
        for row in rows
    ]


def _golf_rolling(player: MeasuredEngine, cloth: Settings, rows: Rows) -> Figures:
    """Yield the deceleration of a golf ball that rolls, without spin and with spin."""
    physics = Physics(motion="sliding", **cloth)
    yield [
        ComparedFigure.of(
            row, decelerations(player.play, physics, spins=row.place > 0.0, rolls=True)[0]
        )
        for row in rows
    ]


def _golf_cloth(_player: MeasuredEngine) -> Settings:
    """Return the friction of the carpet: the weighted mean of the rows of each measurement."""
    means = {}
    for facts in ("spin-golf", "rolling-golf"):
        rows = facts_of(facts).rows
        weights = [1.0 / (row.uncertainty or 1.0) ** 2 for row in rows]
        means[facts] = float(np.average([row.value for row in rows], weights=weights))
    return {
        "spinning_friction_rate": means["spin-golf"],
        "rolling_friction": means["rolling-golf"] / Physics().gravity,
    }


def _breaks(
    outcome: str, player: MeasuredEngine, settings: Settings, rows: Rows
) -> Iterator[list[ComparedFigure]]:
    """Yield the shares of breaks with an outcome.

    Their errors include those of counting the simulated breaks.
    """
    engine = player.engine
    scene = starts_of(setup_of(rows[0].what), Physics(**settings), values_of(), 1).scene
    check_supported(engine.name, engine.capabilities, scene)
    if engine.name != OURS:
        raise OperatorError(
            f"{BREAKS} breaks, one after another, would take this engine too long; "
            "`python -m benchmarks made-balls` counts fewer"
        )
    figures = []
    for row in rows:
        counts = _our_breaks(row.what)
        count = counts.clean if row.without_scratch else getattr(counts, outcome)
        error = math.hypot(row.uncertainty or 0.0, binomial_error(count, counts.breaks))
        figures.append(
            ComparedFigure(
                at=row.place,
                value=row.value,
                error=error,
                played=count / counts.breaks,
                what=row.what,
            )
        )
    yield figures


@cache  # the breaks are the same whatever is counted
def _our_breaks(setup: str) -> BreakCounts:
    engine, values = make_engine(OURS), values_of()
    fields = break_physics(OURS, engine.capabilities, values)
    assert fields is not None
    starts = starts_of(setup_of(setup), Physics(**fields), values, BREAKS)
    return count_breaks(setup_of(setup), starts)


def _of_breaks(player: MeasuredEngine) -> Settings | None:
    return break_physics(player.engine.name, player.engine.capabilities, values_of())


def _without_error(row: FactRow, value: float, played: float, what: str = "") -> ComparedFigure:
    return ComparedFigure(at=row.place, value=value, error=None, played=played, what=what)


def _pool_friction(player: MeasuredEngine) -> Settings:
    """Return the ball friction of `pool`, or of `pool-coulomb` if it can't depend on speed."""
    falls = has_feature(player.engine.capabilities, Feature.SPEED_DEPENDENT_FRICTION)
    return _of_balls("pool" if falls else "pool-coulomb")


def _of_balls(preset: str) -> Settings:
    """Return the coefficients of a preset that act between balls."""
    physics = Physics(preset=preset)
    return {name: getattr(physics, name) for name in ("ball_restitution", "ball_friction")}


MEASUREMENTS: Final[
    Mapping[
        str,
        tuple[
            Callable[[MeasuredEngine], Settings | None],
            Callable[[MeasuredEngine, Settings, Rows], Figures],
        ],
    ]
] = {
    "cushion-carom": (lambda player: player.cushion("cushion-carom"), _carom_rebounds),
    "rolling-pool": (
        lambda player: best_cloth("rolling-pool", player.engine.capabilities),
        _pool_rolling,
    ),
    "banks-pool": (lambda player: player.cushion("banks-pool"), _banks),
    "cushion-snooker": (lambda player: player.cushion("cushion-snooker"), _snooker_rebounds),
    "hits-materials": (
        lambda _: _as_measured("ball_restitution", "ball_friction"),
        _hits_of_materials,
    ),
    "hits-unequal": (lambda _: _as_measured("ball_restitution"), _head_on_hits),
    "hits-snooker": (lambda _: _of_balls("snooker"), _oblique_hits),
    "throw-pool": (_pool_friction, _throws),
    "throw-frozen": (_pool_friction, _frozen_throws),
    "spin-golf": (_golf_cloth, _golf_spin),
    "rolling-golf": (_golf_cloth, _golf_rolling),
    "breaks-made": (_of_breaks, partial(_breaks, "made")),
    "breaks-scratch": (_of_breaks, partial(_breaks, "scratch")),
    "breaks-eight": (_of_breaks, partial(_breaks, "eight")),
}
"""For each table of facts: a function that returns the best settings (None: no suitable cushion
law), and a function that simulates its figures.
"""
