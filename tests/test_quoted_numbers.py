"""Numbers that pages quote are those of committed measurements; an older number fails here."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from PIL import Image

from benchmarks.accuracy import AccuracyMeasurement
from benchmarks.breaks import BreaksMeasurement
from benchmarks.made_balls import MadeBallsMeasurement
from benchmarks.measurements import committed
from benchmarks.pictures.rebounds import best_of_each
from benchmarks.racks import RacksMeasurement
from benchmarks.rebounds import ReboundsMeasurement
from benchmarks.skips import SkipsMeasurement
from benchmarks.speed import TargetsMeasurement
from benchmarks.strokes import StrokesMeasurement
from benchmarks.uneven import UnevenMeasurement
from ghostball.validation.precision.points import PrecisionMeasurement
from ghostball.validation.scenes.library import select

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
MEASUREMENTS = ROOT / "benchmarks/results/amd-epyc-2-cores"
ON_XEON = ROOT / "benchmarks/results/intel-r-xeon-r-processor-2-cores"


def on_one_line(page: str) -> str:
    return " ".join((ROOT / page).read_text(encoding="utf-8").split())


MEASURED = on_one_line("docs/measured.md")


def of_two_digits(seconds: float) -> str:
    """Return a time as pages quote it [ms]."""
    return f"{float(f'{1e3 * seconds:.2g}'):g}"


def of_targets(workload: str, *whats: str) -> tuple[str, ...]:
    rows = TargetsMeasurement.load(ON_XEON / "targets.json")
    return tuple(of_two_digits(rows.row(workload, what).median) for what in whats)


def of_starts() -> tuple[str, ...]:
    targets = TargetsMeasurement.load(ON_XEON / "targets.json")
    warm, cold = (targets.row(start, "first_shot").median for start in ("start", "cold-start"))
    return f"{warm:.1f}", f"{cold:.0f}"


def of_racks() -> tuple[str, ...]:
    racks = RacksMeasurement.load(MEASUREMENTS / "racks.json")
    (ours,) = (one.figures for one in racks.engines if one.engine == "ghostball")
    return tuple(of_two_digits(seconds) for seconds in (ours.mean, ours.p99, ours.greatest))


def of_breaks() -> tuple[str, ...]:
    breaks = BreaksMeasurement.load(MEASUREMENTS / "breaks.json")
    assert (breaks.breaks, breaks.threads, breaks.not_at_rest) == (1_000_000, 2, 0)
    mean = breaks.events / breaks.breaks
    return f"{breaks.seconds:.0f}", f"{mean:.0f}", str(breaks.most_events)


def accuracy() -> AccuracyMeasurement:
    return AccuracyMeasurement.load(MEASUREMENTS / "accuracy.json")


def of_accuracy() -> tuple[str, ...]:
    stored = accuracy()
    assert (stored.invented, stored.faulty) == (0, ())
    return str(stored.events), str(stored.shots), str(stored.missing)


def of_first_result() -> tuple[str, ...]:
    """Return what the cut of 30 degrees was off: medians over where in a step the hit falls."""
    points = PrecisionMeasurement.load(MEASUREMENTS / "precision.json").points
    error = {p.label: p.error for p in points if p.scene == "half-ball-cut"}
    stepped = (f"{1e3 * error[f'{name}:dt=0.001']:.1f}" for name in ("pymunk", "pybullet"))
    return *stepped, f"{error['ghostball']:.1e}"


def of_strokes() -> tuple[str, ...]:
    measured = StrokesMeasurement.load(MEASUREMENTS / "strokes.json")
    strokes, velocities = measured.rows
    git = measured.environment["git"]
    assert (measured.shots, git["dirty"]) == (100_000, False)
    times = strokes.seconds, 1e6 * strokes.per_start, velocities.seconds
    return *(f"{one:.1f}" for one in times), git["revision"][:7]


def of_rebounds() -> tuple[str, ...]:
    found = best_of_each(committed(ReboundsMeasurement))
    best = {one.engine: f"{one.typical:.1f}" for one in found}
    return best["ghostball"], best["pymunk"], best["pybullet"]


def of_uneven() -> tuple[str, ...]:
    stored = UnevenMeasurement.load(MEASUREMENTS / "uneven.json")
    return f"{stored.ratio('uneven'):.2f}", f"{stored.ratio('lasting'):.1f}"


def of_closed_forms() -> tuple[str, ...]:
    scenes = select()
    return str(sum("closed-form" in one.tags for one in scenes)), str(len(scenes))


QUOTED = {
    **{
        f"times of {scene}": (
            "docs/measured.md",
            rf"([\d.]+) ms \| ([\d.]+) ms[^`]*\| `{scene}` \|",
            lambda scene=scene: of_targets(f"scene:{scene}", "call", "kernel"),
        )
        for scene in ("break-16", "break-16@8", "pool-break-9", "galperin-3")
    },
    "the first shot": (
        "docs/measured.md",
        r"first shot in a new process takes ([\d.]+) s\. .* compiled first, it takes (\d+) s",
        of_starts,
    ),
    "racks": (
        "docs/measured.md",
        r"takes ([\d.]+) ms on average, and 99 of 100 racks take at most ([\d.]+) ms\. "
        r"The slowest rack takes ([\d.]+) ms",
        of_racks,
    ),
    "a million breaks": (
        "docs/measured.md",
        r"two threads in (\d+) s\. .* has (\d+) events on average, and at most (\d+)\.",
        of_breaks,
    ),
    "exactness": (
        "docs/measured.md",
        r"Of the (\d+) certified events in (\d+) random shots, Ghostball's engine misses (\d+)\.",
        of_accuracy,
    ),
    "exactness in the paper": (
        "paper/paper.md",
        r"Of ([\d ]+) events proved in ([\d ]+) random shots",
        lambda: tuple(f"{int(one):,}".replace(",", " ") for one in of_accuracy()[:2]),
    ),
    "the most that the engine errs": (
        "docs/measured.md",
        r"The engine errs by at most (\d+) times",
        lambda: (f"{accuracy().quality_factor.greatest:.0f}",),
    ),
    "the first result": (
        "docs/measured.md",
        r"step of 1 ms, pymunk has a rest error of ([\d.]+) mm and pybullet of ([\d.]+) mm\. .* "
        r"The rest error of Ghostball's own engine is ([\d.e-]+) m\.",
        of_first_result,
    ),
    "strokes": (
        "docs/planning.md",
        r"takes ([\d.]+) s on these cores\. .* takes ([\d.]+) µs of processor time\. .* take "
        r"([\d.]+) s\. .* at revision (\w+)\.",
        of_strokes,
    ),
    "rebounds": (
        "README.md",
        r"Ghostball's engine reproduces .* to ([\d.]+) standard errors \(root mean square\), "
        r"pymunk to ([\d.]+) and pybullet to ([\d.]+)\.",
        of_rebounds,
    ),
    "uneven racks": (
        "docs/physics.md",
        r"racks with uneven gaps take ([\d.]+) times as long\. With impacts that last, they take "
        r"([\d.]+) times as long",
        of_uneven,
    ),
    "closed forms": (
        "docs/truth.md",
        r"shipped scenes have one \((\d+) of (\d+)\)",
        of_closed_forms,
    ),
}
"""By what a number is of: the page, the sentence, and what was measured."""


@pytest.mark.parametrize("what", QUOTED)
def test_a_number_is_that_measured(what):
    page, sentence, measured = QUOTED[what]
    assert re.search(sentence, on_one_line(page)).groups() == measured()


def test_parts_that_kernels_leave_out_save_what_is_said():
    said = "`break-16` takes at least a tenth less time than with the full version"
    assert said in on_one_line("docs/inside.md")
    rows = SkipsMeasurement.load(ON_XEON / "skips.json").rows
    mine = [row for row in rows if row.scene == "break-16"]
    saved = {row.skip: 1.0 - row.seconds_on / row.seconds_off for row in mine}
    assert saved["air-and-flight"] >= 1 / 10


REVISIONS = {
    "targets": r"measured at revision ([0-9a-f]{7,40})",
    "racks": r"These racks were measured at revision ([0-9a-f]{7,40})",
    "precision": r"whole call, at revision ([0-9a-f]{7,40})",
    "accuracy": r"certified at revision ([0-9a-f]{7,40})",
    "breaks": r"This was measured at revision (\w+)",
}


@pytest.mark.parametrize("kind", REVISIONS)
def test_what_is_quoted_is_of_the_revision_that_is_named(kind):
    """Numbers of another state of the code than the one they are said to be of fail here."""
    revision = re.search(REVISIONS[kind], MEASURED)[1]
    folder = ON_XEON if kind == "targets" else MEASUREMENTS
    text = (folder / f"{kind}.json").read_text(encoding="utf-8")
    git = json.loads(text)["environment"]["git"]
    assert git["revision"].startswith(revision)
    assert not git["dirty"]


SECTIONS_AT = re.search(r"pictures drawn at revision (\w{7})", on_one_line("docs/paper.md"))[1]
HERO_AT = re.search(r"This picture is drawn at revision (\w{7})", MEASURED)[1]
DRAWN_AT = re.search(r"are drawn at revision (\w{7})", MEASURED)[1]


@pytest.mark.checkout
@pytest.mark.parametrize("name", [path.name for path in sorted((DOCS / "pictures").glob("*"))])
def test_every_picture_is_of_the_revision_that_is_named(name):
    revision = Image.open(DOCS / "pictures" / name).text["Description"]
    own = {
        "precision.png": PrecisionMeasurement,
        "racks.png": RacksMeasurement,
        "rebounds.png": ReboundsMeasurement,
        "breaks.png": MadeBallsMeasurement,
        "steps.png": PrecisionMeasurement,
    }
    named = SECTIONS_AT if name.startswith("paper-section") else DRAWN_AT
    if name == "hero.png":
        named = HERO_AT
    if name in own:
        named = committed(own[name]).environment["git"]["revision"]
    assert revision.startswith(named)
    assert "changes" not in revision
