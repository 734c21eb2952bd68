"""Results of engines in the stress families, from stored records."""

from __future__ import annotations

import shlex
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from ghostball.validation.checks.verdict import is_unfinished, unfinished_text
from ghostball.validation.results.files import cannot_write
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.time_steps import step_in
from ghostball.validation.stress.families import FAMILIES, path_of
from ghostball.validation.stress.shots import parameters_of

Standing = Literal["passed", "failed", "not judged", "unsupported"]

UNITS: Final[Mapping[str, str]] = {
    "depth": "diameters",
    "gap": "m",
    "speed": "m/s",
    "table": "m",
    "distance": "m",
    "length": "s",
    "angle": "degrees",
}
"""Units of the varied quantities; quantities without an entry are pure numbers."""


def standing_of(case: CaseRecord) -> Standing:
    """Return whether an engine passed a shot."""
    if case.outcome in ("not-representable", "unavailable"):
        return "unsupported"
    if is_unfinished(case) or case.passed is False:
        return "failed"
    return "passed" if case.passed else "not judged"


def family_of(case: CaseRecord) -> str:
    """Return the family of a shot."""
    return case.tags[1]


def are_stress(cases: Sequence[CaseRecord]) -> bool:
    """Return True if there are cases and all of them are shots of stress families.

    A scene of a user may have the tag "stress" too.
    """
    return bool(cases) and all(_is_generated(case) for case in cases)


def _is_generated(case: CaseRecord) -> bool:
    kind, family = [*case.tags, "", ""][:2]
    return kind == "stress" and family in FAMILIES and case.scene.startswith(f"{family}.")


@dataclass(frozen=True)
class FamilyTally:
    """Results of an engine in a family."""

    cases: tuple[CaseRecord, ...] = ()

    def count(self, standing: Standing) -> int:
        """Return how many shots have this standing."""
        return sum(standing_of(case) == standing for case in self.cases)

    @property
    def failed(self) -> list[CaseRecord]:
        """The shots that the engine failed."""
        return [case for case in self.cases if standing_of(case) == "failed"]

    @property
    def text(self) -> str:
        """Passed and judged shots for tables, such as "3/4" or "3/4, 2 not judged"."""
        judged = self.count("passed") + self.count("failed")
        unjudged = self.count("not judged")
        more = f"{unjudged} not judged" if unjudged else ""
        passed = f"{self.count('passed')}/{judged}" if judged else ""
        return ", ".join(filter(None, (passed, more))) or "–"


def tallies(cases: Iterable[CaseRecord]) -> dict[tuple[str, str], FamilyTally]:
    """Return the results of each engine in each family, in the order of the families."""
    found: dict[tuple[str, str], list[CaseRecord]] = defaultdict(list)
    for case in cases:
        found[family_of(case), case.label].append(case)
    order = list(FAMILIES)
    keys = sorted(found, key=lambda key: order.index(key[0]))
    return {key: FamilyTally(tuple(found[key])) for key in keys}


@dataclass(frozen=True)
class Sweep:
    """Values of one varied quantity of a family at which engines fail.

    `parameter`: the varied quantity, with its unit.
    `values`: its values, in increasing order.
    `fails`: for each engine, the values at which it fails, in words; "" if it ran no shot.
    """

    family: str
    parameter: str
    values: tuple[float, ...]
    fails: Mapping[str, str]


def sweeps(cases: Sequence[CaseRecord]) -> list[Sweep]:
    """Return the values at which engines fail, for each quantity that a family varies."""
    found: dict[tuple[str, str], list[tuple[float, CaseRecord]]] = defaultdict(list)
    for case in cases:
        for name, value in parameters_of(case.tags).items():
            found[family_of(case), name].append((value, case))
    labels = list(dict.fromkeys(case.label for case in cases))
    return [
        Sweep(
            family,
            f"{name} [{UNITS[name]}]" if name in UNITS else name,
            tuple(sorted({value for value, _ in pairs})),
            {label: _failing([one for one in pairs if one[1].label == label]) for label in labels},
        )
        for (family, name), pairs in found.items()
    ]


def _failing(pairs: Sequence[tuple[float, CaseRecord]]) -> str:
    """Return the values at which an engine fails: "never", "≥ 80", "≤ 1e-07, 0.1"."""
    judged: dict[float, bool] = {}
    for value, case in pairs:
        standing = standing_of(case)
        if standing in ("passed", "failed"):
            judged[value] = judged.get(value, False) or standing == "failed"
    values = sorted(judged)
    bad = [value for value in values if judged[value]]
    if not bad:
        return "never" if values else ""
    if len(bad) == len(values):
        return "always"
    low = next(k for k, value in enumerate(values) if not judged[value])
    high = next(k for k, value in enumerate(reversed(values)) if not judged[value])
    parts = [f"≤ {values[low - 1]:g}"] * (low > 0)
    parts += [f"{one:g}" for one in bad if values[low] < one < values[-1 - high]]
    if high:
        parts.append(f"≥ {values[-high]:g}{_in_a_step(values[-high], pairs)}")
    return ", ".join(parts)


def _in_a_step(speed: float, pairs: Sequence[tuple[float, CaseRecord]]) -> str:
    """Return a speed in diameters per time step, for the family that needs this unit."""
    case = pairs[0][1]
    step = step_in(case.settings)
    if family_of(case) != "tunnelling" or step is None:
        return ""
    way = speed * step / (2.0 * float(case.definition["balls"][0]["radius"]))
    return f" ({way:.2g} diameters a time step)"


def why_failed(case: CaseRecord) -> str:
    """Return why an engine failed a shot, in a sentence."""
    broken = [check.sentence for check in case.checks if check.passed is False]
    return unfinished_text(case) or broken[0]


def again(case: CaseRecord) -> str:
    """Return the command that runs a shot again."""
    return f"ghostball stress {shlex.quote(path_of(case.scene))} -e {shlex.quote(case.label)}"


def explaining(case: CaseRecord, folder: Path) -> str:
    """Save the scene of a shot in a results folder; return the command that explains the error."""
    file = folder / "scenes" / f"{case.scene}.toml"
    try:
        file.parent.mkdir(exist_ok=True)
        case.load_scene().save(file)
    except OSError as error:
        raise cannot_write(folder, error) from error
    return f"ghostball explain {shlex.quote(str(file))} -e {shlex.quote(case.label)}"
