"""README and docs/ tell the truth: programs run, figures are those that were measured."""

import json
import re
import shlex
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from PIL import Image
from typer.main import get_command
from typer.testing import CliRunner

from benchmarks.accuracy import AccuracyMeasurement
from benchmarks.breaks import BreaksMeasurement
from benchmarks.measurements import committed
from benchmarks.pictures.rebounds import best_of_each
from benchmarks.racks import RacksMeasurement
from benchmarks.rebounds import ReboundsMeasurement
from benchmarks.skips import SkipsMeasurement
from benchmarks.speed import TargetsMeasurement
from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT
from ghostball.model import Ball, Physics
from ghostball.model.rounding import CONTACT_TOLERANCE
from ghostball.reference_adapters import EngineUnavailableError, engine_names, make_engine
from ghostball.validation.precision.points import PrecisionMeasurement
from ghostball.validation.scenes.library import find_scene, select

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
PHYSICS = (ROOT / "docs/physics.md").read_text(encoding="utf-8")
MEASURED_PAGE = (ROOT / "docs/measured.md").read_text(encoding="utf-8")
PAPER = (ROOT / "docs/paper.md").read_text(encoding="utf-8")
TRUTH = (ROOT / "docs/truth.md").read_text(encoding="utf-8")
MEASUREMENTS = ROOT / "benchmarks/results/amd-epyc-2-cores"
MEASURED = TargetsMeasurement.load(MEASUREMENTS / "targets.json")
GALLERY = ROOT / "docs/pictures"


def on_one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def row_of(part: str) -> list[str]:
    """Return the cells of a row of the table: default and why, other choices, source."""
    (row,) = (line for line in PHYSICS.splitlines() if line.startswith(f"| {part} |"))
    return [cell.strip() for cell in row.strip("|").split("|")][1:]


def choices_of(field: str) -> set[str]:
    return set(Physics.model_json_schema()["properties"][field]["enum"])


def test_the_program_runs(capsys):
    program = re.search(r"```python\n(.*?)```", README, re.DOTALL)[1]
    assert len(program.splitlines()) <= 10
    names = {}
    exec(compile(program, "README.md", "exec"), names)
    assert "ball-ball" in capsys.readouterr().out
    difference = abs(names["other"].rest_positions - names["exact"].rest_positions).max()
    assert 0.5e-3 < difference < 2e-3  # "a millimetre"


@pytest.mark.slow
def test_the_program_passes_a_strict_type_check(tmp_path):
    program = tmp_path / "readme.py"
    program.write_text(re.search(r"```python\n(.*?)```", README, re.DOTALL)[1])
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout


def documented_settings() -> list[str]:
    """Return the specs of shipped engines with settings that README and docs/ print."""
    pages = (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    spec = re.compile(r"(?<![\w/.-])([a-z][\w-]*:[a-z_]+=[\w.,=/-]*[\w])")
    found = {one for page in pages for one in spec.findall(page.read_text(encoding="utf-8"))}
    return sorted(one for one in found if one.partition(":")[0] in engine_names())


@pytest.mark.parametrize("spec", documented_settings())
def test_an_engine_takes_the_settings_that_the_docs_print(spec):
    with suppress(EngineUnavailableError):  # raised once the settings have been accepted
        make_engine(spec)


def test_it_is_short_and_begins_with_what_its_first_command_prints(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert len(README.splitlines()) <= 60
    assert "    make smoke " in README.split("## Start")[1].split("    make validate")[0]
    (heads, cells) = re.search(
        r"prints:\n\n {4}(scene .*)\n {4}(half-ball-cut .*)\n", README
    ).groups()
    engines = heads.split()[1:]
    arguments = [part for engine in engines for part in ("-e", engine)]
    done = CliRunner().invoke(app, ["validate", "half-ball-cut", *arguments, "--no-report"])
    printed = [line.split() for line in done.stdout.splitlines()]
    assert [*heads.split()] in printed
    assert [*cells.split()] in printed
    (first,) = re.search(r"lets a ball rest ([\d.]+) mm", on_one_line(README)).groups()
    assert cells.split()[cells.split().index("mm") - 1] == first


def test_every_name_in_it_can_be_typed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^ {4}ghostball (.*?)(?: {2,}#.*)?$", README, re.MULTILINE)
    assert len(commands) == 5
    named = {name for one in commands for name in re.findall(r"-e (\S+)", one)}
    assert CliRunner().invoke(app, ["init"]).exit_code == 0
    for name in named:
        assert CliRunner().invoke(app, ["run", "stop", "-e", name]).exit_code == 0, name
    for one in commands:
        command = get_command(app).commands[one.split()[0]]
        command.make_context(one.split()[0], shlex.split(one)[1:])


@pytest.mark.checkout
def test_its_links_lead_somewhere():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert target.startswith("https://") or (ROOT / target).exists(), target


@pytest.mark.parametrize("scene", ["break-16", "break-16@8", "pool-break-9", "galperin-3"])
def test_times_are_those_measured(scene):
    """Rounded to two digits; a new measurement that is not carried over to README fails here."""
    (row,) = (line for line in MEASURED_PAGE.splitlines() if line.endswith(f"| `{scene}` |"))
    said = re.findall(r"([\d.]+) ms", row)
    measured = [MEASURED.row(f"scene:{scene}", what).median for what in ("call", "kernel")]
    assert said == [f"{float(f'{1e3 * median:.2g}'):g}" for median in measured]


def test_the_times_of_racks_are_those_measured():
    said = re.search(
        r"on average ([\d.]+) ms, 99 of 100 at most ([\d.]+) ms, and the slowest ([\d.]+) ms",
        on_one_line(MEASURED_PAGE),
    )
    racks = RacksMeasurement.load(MEASUREMENTS / "racks.json")
    (ours,) = (one.figures for one in racks.engines if one.engine == "ghostball")
    times = (ours.mean, ours.p99, ours.slowest)
    assert said.groups() == tuple(f"{float(f'{1e3 * seconds:.2g}'):g}" for seconds in times)


def test_a_million_breaks_are_as_measured():
    said = re.search(
        r"played on two threads in (\d+) s: on average (\d+) events until all balls rest, at most "
        r"(\d+)\. This was measured at revision (\w+)",
        on_one_line(MEASURED_PAGE),
    )
    file = MEASUREMENTS / "breaks.json"
    breaks = BreaksMeasurement.load(file)
    assert (breaks.breaks, breaks.threads, breaks.not_at_rest) == (1_000_000, 2, 0)
    mean = breaks.events / breaks.breaks
    assert said.groups()[:3] == (f"{breaks.seconds:.0f}", f"{mean:.0f}", str(breaks.most_events))
    assert breaks.environment["git"]["revision"].startswith(said[4])
    assert not breaks.environment["git"]["dirty"]


def test_parts_that_kernels_leave_out_save_what_is_said():
    """Of a break of 16; whether cells and air are there, the scene decides."""
    page = on_one_line((ROOT / "docs/inside.md").read_text(encoding="utf-8"))
    assert "makes `break-16` faster by more than a twentieth, contacts by a quarter" in page
    rows = SkipsMeasurement.load(MEASUREMENTS / "skips.json").rows
    saved = {
        row.skip: 1.0 - row.seconds_on / row.seconds_off for row in rows if row.scene == "break-16"
    }
    assert saved["integrated-laws"] > 0.05
    assert saved["contacts"] > 0.25


def test_the_first_shot_is_as_measured():
    said = re.search(
        r"first shot takes ([\d.]+) s, .* compiled first, (\d+) s", on_one_line(MEASURED_PAGE)
    )
    warm, cold = (MEASURED.row(start, "first_shot").median for start in ("start", "cold-start"))
    assert said.groups() == (f"{warm:.1f}", f"{cold:.0f}")


MEASURED_AT = re.search(r"measured at revision ([0-9a-f]{7,40})", on_one_line(MEASURED_PAGE))[1]
RACKED_AT = re.search(r"played each, at revision ([0-9a-f]{7,40})", on_one_line(MEASURED_PAGE))[1]
COMPARED_AT = re.search(r"whole call, at revision ([0-9a-f]{7,40})", on_one_line(MEASURED_PAGE))[1]
SECTIONS_AT = re.search(r"pictures drawn at revision (\w{7})", on_one_line(PAPER))[1]
DRAWN_AT = re.search(r"[Dd]rawn at revision (\w{7})", on_one_line(MEASURED_PAGE))[1]
PROVED_AT = re.search(r"proved at revision ([0-9a-f]{7,40})", on_one_line(MEASURED_PAGE))[1]


@pytest.mark.parametrize(
    ("kind", "revision"),
    [
        ("targets", MEASURED_AT),
        ("racks", RACKED_AT),
        ("precision", COMPARED_AT),
        ("accuracy", PROVED_AT),
    ],
)
def test_what_is_quoted_or_drawn_is_of_the_revision_that_is_named(kind, revision):
    """Numbers of another state of the code than the one they are said to be of fail here."""
    text = (MEASUREMENTS / f"{kind}.json").read_text(encoding="utf-8")
    git = json.loads(text)["environment"]["git"]
    assert git["revision"].startswith(revision)
    assert not git["dirty"]


@pytest.mark.checkout
@pytest.mark.parametrize("name", [path.name for path in sorted(GALLERY.glob("*"))])
def test_every_picture_is_of_the_revision_that_is_named(name):
    revision = Image.open(GALLERY / name).text["Description"]
    own = {
        "precision.png": committed(PrecisionMeasurement),
        "racks.png": committed(RacksMeasurement),
        "rebounds.png": committed(ReboundsMeasurement),
        "steps.png": committed(PrecisionMeasurement),
    }
    if name in own:
        assert revision.startswith(own[name].environment["git"]["revision"])
    else:
        sections = name.startswith("paper-section")
        assert revision.startswith(SECTIONS_AT if sections else DRAWN_AT)
    assert "changes" not in revision


def test_how_near_engines_come_to_a_real_table_is_what_was_searched():
    best = {
        one.engine: f"{one.typical:.1f}" for one in best_of_each(committed(ReboundsMeasurement))
    }
    said = re.search(
        r"misses rebounds .* by ([\d.]+) times .*, pymunk by ([\d.]+) and pybullet by "
        r"([\d.]+) times",
        on_one_line(README),
    )
    assert said.groups() == (best["ghostball"], best["pymunk"], best["pybullet"])


def test_exactness_is_what_was_measured():
    page = on_one_line(MEASURED_PAGE)
    said = re.search(r"Of (\d+) events proved in (\d+) random shots it misses (\d+)\.", page)
    events, shots, missing = map(int, said.groups())
    factor = int(re.search(r"the engine errs by at most (\d+) times", page)[1])
    stored = AccuracyMeasurement.load(MEASUREMENTS / "accuracy.json")
    assert (events, shots, missing) == (stored.events, stored.shots, stored.missing)
    assert factor == round(stored.quality_factor.greatest)
    assert (stored.invented, stored.faulty) == (0, ())
    assert not stored.environment["git"]["dirty"]


def test_the_first_result_is_as_measured():
    """Of the cut of 30 degrees; medians over where in a step the collision falls."""
    said = re.search(
        r"step of 1 ms, pymunk lets a ball rest ([\d.]+) mm .* pybullet ([\d.]+) mm, .* off by "
        r"([\d.e-]+) m\.",
        on_one_line(MEASURED_PAGE),
    )
    points = PrecisionMeasurement.load(MEASUREMENTS / "precision.json").points
    error = {p.label: p.error for p in points if p.scene == "half-ball-cut"}
    stepped = (f"{1e3 * error[f'{name}:dt=0.001']:.1f}" for name in ("pymunk", "pybullet"))
    assert said.groups() == (*stepped, f"{error['ghostball']:.1e}")


def test_the_numbers_of_scenes_are_those_shipped():
    """A scene that is added, or given a closed form, and not counted in the page fails here."""
    scenes = select()
    solved = sum("closed-form" in scene.tags for scene in scenes)
    said = re.search(r"shipped scenes have one \((\d+) of (\d+)\)", on_one_line(TRUTH))
    assert (int(said[1]), int(said[2])) == (solved, len(scenes))


class TestTheTableOfModels:
    """A default, preset or law that changes and is not carried over to the table fails here."""

    paper, pool = Physics(), Physics(preset="pool")

    @pytest.mark.parametrize(
        ("part", "field"),
        [
            ("motion", "motion"),
            ("ball-ball law", "ball_impact"),
            ("cushion law", "cushion"),
            ("impacts at one instant", "impacts"),
        ],
    )
    def test_each_choice_stands_in_its_column(self, part, field):
        default, others, _ = row_of(part)
        chosen = getattr(self.paper, field)
        assert default.startswith(f"`{chosen}`")
        assert set(re.findall(r"`(\w+)`", others)) == choices_of(field) - {chosen}
        pool = re.findall(r"`(\w+)` \(pool\)", others)
        assert pool == [getattr(self.pool, field)] * (getattr(self.pool, field) != chosen)

    def test_its_numbers_are_the_defaults(self):
        assert f"mu = {self.paper.rolling_friction:g}:" in row_of("motion")[0]
        rate = re.search(r"by (\d+) rad/s²", row_of("spin about the vertical")[1])[1]
        assert float(rate) == self.paper.spinning_friction_rate == self.pool.spinning_friction_rate
        default, others, _ = row_of("ball-ball restitution, friction")
        assert default.startswith("1 and 0:")
        assert (self.paper.ball_restitution, self.paper.ball_friction) == (1.0, 0.0)
        assert f"(pool: {self.pool.ball_restitution:g})" in others
        assert f"`{self.pool.ball_friction}` (pool)" in others


@pytest.mark.parametrize(
    ("pattern", "tolerance"),
    [
        (r"within 2\^-(\d+) diameters \(([\d.e-]+) m", CONTACT_TOLERANCE),
        (r"below 2\^-(\d+) diameters \(([\d.e-]+) m", CAPTURE_HEIGHT),
    ],
)
def test_the_approximations_are_as_large_as_said(pattern, tolerance):
    said = re.search(pattern, on_one_line(PHYSICS))
    assert 2.0 ** -int(said[1]) == tolerance
    diameter = 2 * Ball(id="a", position=(0.0, 0.0)).radius
    assert float(said[2]) == float(f"{tolerance * diameter:.0e}")


def test_what_it_names_in_work_is_counted():
    named = set(re.findall(r'`work\["(\w+)"\]`', PHYSICS))
    counted = {"contact_steps", "contact_pieces", "joint_impacts", "unsolved_contact_steps"}
    assert named == counted <= set(simulate(find_scene("push")).work)
