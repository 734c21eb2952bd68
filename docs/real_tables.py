"""Tables of `real-tables.md` that compare measurements with simulations, as Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial

import numpy as np

from docs.tables import table
from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.banks import through_points
from ghostball.validation.measured.best_settings import best_cloth, best_cushion
from ghostball.validation.measured.facts import FactRow, facts_of
from ghostball.validation.measured.oblique_hits import oblique_hit, passed_throw, throw_angle
from ghostball.validation.measured.rebounds import rebounds as measured_rebounds, square_rebound
from ghostball.validation.measured.rolling import deceleration
from ghostball.validation.measured.table_agreement import (
    SMALL_GAP,
    MeasuredEngine,
    families_of,
    material_hits as measured_hits,
)

_PLAY = partial(simulate, record="trajectory")
_SYMBOLS = {"cushion_restitution": "e", "cushion_restitution_loss": "c"}


def rebounds() -> str:
    """Return the measured rebounds, and those of the preset `carom`."""
    carom = Physics(preset="carom")
    fixed = carom.model_copy(update={"cushion_restitution": 0.87, "cushion_restitution_loss": 0.0})
    columns = [
        measured_rebounds(_PLAY, physics, degrees)
        for physics, degrees in ((carom, 5.0), (carom, 45.0), (fixed, 5.0))
    ]
    rows = []
    for row, *bins in zip(facts_of("cushion-carom").rows, *columns, strict=True):
        ratios = (f"{one.played:.3f} ({one.errors_off:+.1f})" for one in bins)
        rows.append(
            (f"{row.low:g} to {row.high:g} m/s", f"{row.value:.3f} ± {row.error:.3f}", *ratios)
        )
    heads = ("speed", "measured", "`carom`, 5°", "`carom`, 45°", "one restitution, 0.87, 5°")
    return table(heads, rows)


def pool_rolling() -> str:
    """Return measured decelerations of cue balls, and those of the preset `pool`."""
    facts = facts_of("rolling-pool")
    pool = Physics(preset="pool")
    nearest = best_cloth("rolling-pool", make_engine("ghostball").capabilities)
    rows = []
    for row in facts.rows:
        found = [
            deceleration(_PLAY, pool.model_copy(update=cloth), row.place) for cloth in ({}, nearest)
        ]
        rows.append(
            (f"{row.low:g} to {row.high:g} m/s", _plus_minus(row, 3), *_errors_off(row, found, 3))
        )
    numbers = ", ".join(f"`{name}` {value:.4f}" for name, value in nearest.items())
    return table(("speed", "measured [m/s²]", "`pool`", f"`pool` with {numbers}"), rows)


def snooker_rebounds() -> str:
    """Return square rebounds of snooker: measured, of the preset, and of other laws."""
    measured = facts_of("cushion-snooker").rows
    engines = ("ghostball", "pybullet")  # the first supports a restitution that falls with speed
    best = [
        best_cushion("cushion-snooker", name, make_engine(name).capabilities) or {}
        for name in engines
    ]
    presets = [Physics(preset="snooker", **changes) for changes in ({}, *best)]
    columns = [[square_rebound(_PLAY, one, row.place) for row in measured] for one in presets]
    rows = [
        (
            f"{row.at:g} m/s",
            f"{row.value:.3f} m/s",
            *(f"{one.speed_after:.3f} ({one.speed_after - row.value:+.3f})" for one in contacts),
        )
        for row, *contacts in zip(measured, *columns, strict=True)
    ]
    after = np.array([[one.speed_after for one in contacts] for contacts in columns])
    off = np.sqrt(np.mean((after - [row.value for row in measured]) ** 2, axis=1))
    rows.append(("rms difference", "", *(f"{x:.3f}" for x in off)))
    falls, fixed = (
        ", ".join(f"{symbol} = {one[name]:g}" for name, symbol in _SYMBOLS.items() if one[name])
        for one in best
    )
    heads = ("speed before", "measured, after", "`snooker`")
    return table((*heads, f"`frictional`, {falls}", f"`frictional`, {fixed}"), rows)


def hits() -> str:
    """Return five oblique hits: measured, and of the preset `snooker`."""
    rows = []
    for row in facts_of("hits-snooker").rows:
        speed, cut = row.given["speed"], row.place
        hit = oblique_hit(_PLAY, Physics(preset="snooker"), speed, cut)
        pairs = (
            (row.value, hit.cue_speed, 3),
            (row.also["object_speed"], hit.object_speed, 3),
            (row.also["cue_angle"], hit.cue_angle, 1),
        )
        cells = (f"{measured:.{n}f}, {played:.{n}f}" for measured, played, n in pairs)
        rows.append((f"{speed:.3f} m/s, {cut:.1f}°", *cells))
    heads = ("speed, cut", "cue ball [m/s]", "object ball [m/s]", "cue ball's direction [°]")
    return table(heads, rows)


def material_hits() -> str:
    """Return directions and throw after hits of billiard balls: measured, and of each preset."""
    row = facts_of("hits-materials").rows[0]
    presets = ("pool", "carom", "snooker")
    found = [measured_hits(_PLAY, Physics(preset=name), row) for name in presets]
    rows = []
    for which, name in enumerate(("direction", "throw")):
        for hits in zip(*found, strict=True):
            figures = [hit[which] for hit in hits]
            first = figures[0]
            cells = (f"{one.played:.1f} ({one.errors_off:+.1f})" for one in figures)
            rows.append(
                (f"{name}, {first.at:g}°", f"{first.value:.1f} ± {first.error:.1f}", *cells)
            )
    heads = ("angle, cut", "measured [°]", *(f"`{name}`" for name in presets))
    return table(heads, rows)


def banks() -> str:
    """Return banks of sliding balls: five tables, and the preset `pool` at several speeds."""
    best = best_cushion("banks-pool", "ghostball", make_engine("ghostball").capabilities) or {}
    rows = facts_of("banks-pool").rows
    through = partial(through_points, _PLAY, aims=[row.place for row in rows])
    pool = Physics(preset="pool")
    columns = [through(pool), through(pool, speed=3.0), through(pool, speed=7.0)]
    columns.append(through(Physics(preset="pool", **best)))
    cells = [
        (
            f"{row.at:g}",
            ", ".join(f"{value:.2f}" for value in row.of_each),
            _plus_minus(row, 2),
            *_errors_off(row, found, 2),
        )
        for row, *found in zip(rows, *columns, strict=True)
    ]
    name = f"{best['cushion']}`, e = {best['cushion_restitution']:g}"
    speeds = ("`pool`", "`pool`, 3 m/s", "`pool`, 7 m/s", f"`{name}")
    return table(("aimed at", "aimed from, five tables", "mean ± spread", *speeds), cells)


def throws() -> str:
    """Return throw: measured, of the preset `pool`, and of a contact that sticks."""
    rows = []
    for row in facts_of("throw-pool").rows:
        for cut, value in ((30.0, row.value), (45.0, row.also["at_45_degrees"])):
            played = throw_angle(_PLAY, Physics(preset="pool"), row.place, cut)
            sticks = math.degrees(math.atan(math.tan(math.radians(cut)) / 7.0))
            cells = (f"{one:.1f}°" for one in (value, played, sticks))
            rows.append((f"{row.place:g} m/s, {cut:g}°", *cells))
    return table(("speed, cut", "measured", "`pool`", "largest throw of any friction"), rows)


def frozen_throws() -> str:
    """Return the throw of frozen and of nearly frozen balls: measured, and of the preset `pool`."""
    rows = []
    for row in facts_of("throw-frozen").rows:
        for name, gap, clean, chalk in (
            ("frozen", 0.0, row.value, row.also["chalk"]),
            ("small gap", SMALL_GAP, row.also["gap"], row.also["chalk_gap"]),
        ):
            played = passed_throw(_PLAY, Physics(preset="pool"), 1.0, row.place, gap)
            cells = (f"{one:.1f}°" for one in (clean, chalk, played))
            rows.append((f"{name}, {row.place:g}°", *cells))
    return table(("balls, angle", "measured, clean", "measured, chalk", "`pool`"), rows)


def golf_spin() -> str:
    """Return decelerations of a golf ball: measured, and by one rate of spin and one of rolling."""
    ours = MeasuredEngine(make_engine("ghostball"), _PLAY)
    rows = []
    for name in ("spin-golf", "rolling-golf"):
        (family,) = families_of(name, ours)
        for row, one in zip(facts_of(name).rows, family.figures, strict=True):
            rows.append(
                (
                    f"{family.quantity}, {row.what} [{family.unit.replace('^2', '²')}]",
                    f"{one.value:.3g} ± {one.error:.1g}",
                    f"{one.played:.3g} ({one.errors_off:+.1f})",
                )
            )
    return table(("quantity", "measured", "one number for both"), rows)


def _plus_minus(row: FactRow, digits: int) -> str:
    return f"{row.value:.{digits}f} ± {row.uncertainty:.{digits}f}"


def _errors_off(row: FactRow, found: Iterable[float], digits: int) -> Iterable[str]:
    """Return each value, with its difference from the measurement in standard errors."""
    error = row.uncertainty
    assert error is not None
    return (f"{one:.{digits}f} ({(one - row.value) / error:+.1f})" for one in found)
