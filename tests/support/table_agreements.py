"""Made-up results of engines on real tables: differences in standard errors, or unsupported."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ghostball.validation.measured.figures import ComparedFigure, FigureFamily, TableAgreement
from ghostball.validation.suite.real_tables import AgreementWriter


def family(name: str, off: float | str, *, grades: bool = True) -> FigureFamily:
    """Return a family of three figures with a difference in standard errors, or with a reason.

    `off`: the difference, or the reason why the engine has no figures.
    """
    figures = ()
    if not isinstance(off, str):
        figures = tuple(
            ComparedFigure(at=at, value=0.5, error=0.1, played=0.5 + 0.1 * off)
            for at in (0.5, 1.0, 1.5)
        )
    return FigureFamily(
        name=name,
        short=name,
        title=name.title(),
        quantity="ratio",
        unit="1",
        against="speed [m/s]",
        citation="Somebody 2024",
        figures=figures,
        lacks="" if figures else str(off),
        failed=str(off).startswith("it failed"),
        grades=grades,
    )


def likeness(label: str, **off: float | str) -> TableAgreement:
    """Return the results of an engine for families with these names."""
    return TableAgreement(
        label=label, families=tuple(family(name, one) for name, one in off.items())
    )


def keep_likenesses(folder: Path, found: Iterable[TableAgreement]) -> None:
    """Store results on real tables in a folder, as a run does."""
    writer = AgreementWriter(folder)
    writer.begin({})
    for one in found:
        writer.write(one)
    writer.finish("complete")
