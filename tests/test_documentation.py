"""README and docs/ are right: programs run, tables are those of the code, sources are listed."""

from __future__ import annotations

import ast
import os
import re
import shlex
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT
from ghostball.model import Ball, Physics
from ghostball.model.rounding import CONTACT_TOLERANCE
from ghostball.reference_adapters import EngineUnavailableError, engine_names, make_engine
from ghostball.validation.scenes.library import find_scene

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BIN = Path(sys.executable).parent


def on_one_line(page: str) -> str:
    return " ".join((ROOT / page).read_text(encoding="utf-8").split())


README = (ROOT / "README.md").read_text(encoding="utf-8")
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
PHYSICS = (DOCS / "physics.md").read_text(encoding="utf-8")

# --- programs and commands that pages show

PROGRAM = re.search(r"```python\n(.*?)```", README, re.DOTALL)[1]


def test_the_program_runs(capsys):
    assert len(PROGRAM.splitlines()) <= 10
    names = {}
    exec(compile(PROGRAM, "README.md", "exec"), names)
    assert "ball-ball" in capsys.readouterr().out
    difference = abs(names["other"].rest_positions - names["exact"].rest_positions).max()
    assert 0.5e-3 < difference < 2e-3  # "about 1 mm"


@pytest.mark.slow
def test_the_program_passes_a_strict_type_check(tmp_path):
    (tmp_path / "readme.py").write_text(PROGRAM)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "readme.py"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout


def documented_settings() -> list[str]:
    """Return the specs of shipped engines with settings that README and docs/ print."""
    spec = re.compile(r"(?<![\w/.-])([a-z][\w-]*:[a-z_]+=[\w.,=/-]*[\w])")
    pages = (ROOT / "README.md", *DOCS.rglob("*.md"))
    found = {one for page in pages for one in spec.findall(page.read_text(encoding="utf-8"))}
    return sorted(one for one in found if one.partition(":")[0] in engine_names())


@pytest.mark.parametrize("spec", documented_settings())
def test_an_engine_takes_the_settings_that_the_docs_print(spec):
    with suppress(EngineUnavailableError):  # raised once the settings have been accepted
        make_engine(spec)


def test_it_is_short_and_begins_with_commands_that_install_what_they_need():
    assert len(README.splitlines()) <= 60
    start = README.split("## ")[0]
    for target in re.findall(r"^ {4}make ([a-z]+)", start, re.MULTILINE):
        assert re.search(rf"^{target}: (\$\((USABLE|READY)\)|kernels)", MAKEFILE, re.MULTILINE), (
            target
        )
    assert "    make smoke " in start.split("    make validate")[0]


def test_the_first_error_that_it_quotes_is_what_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = ["validate", "half-ball-cut", "-e", "pymunk", "--no-report"]
    (quoted,) = re.search(
        r"has a rest position error of ([\d.]+ mm)", on_one_line("README.md")
    ).groups()
    assert quoted in " ".join(CliRunner().invoke(app, command).stdout.split())


def test_the_mistake_that_it_plants_is_found(tmp_path):
    (planted,) = re.findall(r"^ {4}(sed .*)$", README, re.MULTILINE)
    for command in ("ghostball init", planted, "ghostball explain stop -e wrong:simulate"):
        done = subprocess.run(
            command,
            shell=True,  # as a reader types it
            cwd=tmp_path,
            env=os.environ | {"PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "90"},
            capture_output=True,
            text=True,
            check=True,
        )
    assert command in README
    quoted = " ".join(re.findall(r"^> (.*)$", README, re.MULTILINE))
    # As far as no machine rounds: what is left of the error depends on the step.
    assert quoted.split(" The error")[0] in " ".join(done.stdout.split())
    (error,) = re.search(r"The error, [^,]+, is (\d+ mm)\.", quoted).groups()
    assert f"is {error}." in " ".join(done.stdout.split())


def test_every_name_in_it_can_be_typed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^ {4}ghostball (.*?)(?: {2,}#.*)?$", README, re.MULTILINE)
    assert len(commands) == 4
    assert CliRunner().invoke(app, ["init"]).exit_code == 0
    shutil.copy("my_engine.py", "wrong.py")
    named = {name for one in commands for name in re.findall(r"-e (\S+)", one)}
    for name in named:
        assert CliRunner().invoke(app, ["run", "stop", "-e", name]).exit_code == 0, name
    for one in commands:
        command = get_command(app).commands[one.split()[0]]
        command.make_context(one.split()[0], shlex.split(one)[1:])


@pytest.mark.checkout
def test_every_file_that_a_page_names_exists():
    tracked = subprocess.check_output(["git", "ls-files"], text=True, cwd=ROOT)
    files = [f"/{name}" for name in tracked.split()]
    assert len(files) > 500
    page = (DOCS / "inside.md").read_text(encoding="utf-8")
    named = set(re.findall(r"(?<![*\w./])[\w/]+\.(?:py|toml)\b", page))
    assert len(named) > 40
    for path in [*ROOT.glob("*.md"), *DOCS.rglob("*.md")]:
        paths = re.findall(r"`(\w+/[\w./-]+\.\w+)`", path.read_text(encoding="utf-8"))
        named |= {
            one for one in paths if any(f.startswith(f"/{one.split('/')[0]}/") for f in files)
        }
    missing = [name for name in named if not any(f.endswith(f"/{name}") for f in files)]
    assert not sorted(missing)


def test_its_links_lead_somewhere():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert target.startswith("https://") or (ROOT / target).exists(), target


# --- the table of models: a default, preset or law that isn't carried over to it fails here

PAPER, POOL = Physics(), Physics(preset="pool")


def row_of(part: str) -> list[str]:
    """Return the cells of a row of the table: default and why, other choices, source."""
    (row,) = (line for line in PHYSICS.splitlines() if line.startswith(f"| {part} |"))
    return [cell.strip() for cell in row.strip("|").split("|")][1:]


@pytest.mark.parametrize(
    ("part", "field"),
    [
        ("motion", "motion"),
        ("ball-ball law", "ball_impact"),
        ("cushion law", "cushion"),
        ("impacts of several balls", "impacts"),
    ],
)
def test_each_choice_stands_in_its_column(part, field):
    default, others, _ = row_of(part)
    chosen, of_pool = getattr(PAPER, field), getattr(POOL, field)
    choices = set(Physics.model_json_schema()["properties"][field]["enum"])
    assert default.startswith(f"`{chosen}`")
    assert set(re.findall(r"`(\w+)`", others)) == choices - {chosen}
    assert re.findall(r"`(\w+)` \(pool\)", others) == [of_pool] * (of_pool != chosen)


def test_its_numbers_are_the_defaults():
    assert f"mu = {PAPER.rolling_friction:g}," in row_of("motion")[0]
    rate = re.search(r"by (\d+) rad/s²", row_of("spin about the vertical")[1])[1]
    assert float(rate) == PAPER.spinning_friction_rate == POOL.spinning_friction_rate
    default, others, _ = row_of("ball-ball restitution, friction")
    assert default.startswith("1 and 0:")
    assert (PAPER.ball_restitution, PAPER.ball_friction) == (1.0, 0.0)
    assert f"(pool: {POOL.ball_restitution:g})" in others
    assert f"`{POOL.ball_friction}` (pool)" in others


@pytest.mark.parametrize(
    ("pattern", "tolerance"),
    [
        (r"within 2\^-(\d+) diameters \(([\d.e-]+) m", CONTACT_TOLERANCE),
        (r"below 2\^-(\d+) diameters \(([\d.e-]+) m", CAPTURE_HEIGHT),
    ],
)
def test_the_approximations_are_as_large_as_said(pattern, tolerance):
    said = re.search(pattern, on_one_line("docs/physics.md"))
    assert 2.0 ** -int(said[1]) == tolerance
    diameter = 2 * Ball(id="a", position=(0.0, 0.0)).radius
    assert float(said[2]) == float(f"{tolerance * diameter:.0e}")


def test_what_it_names_in_work_is_counted():
    named = set(re.findall(r'`work\["(\w+)"\]`', PHYSICS))
    counted = {"contact_steps", "contact_pieces", "joint_impacts", "unsolved_contact_steps"}
    assert counted <= set(simulate(find_scene("push")).work)
    scene = find_scene("break-7")
    compliant = Physics(**{**dict(scene.physics), "impacts": "compliant", "ball_restitution": 0.9})
    shot = simulate(scene.model_copy(update={"physics": compliant, "t_max": 1.0}))
    assert named - counted == {"compliant_impacts"} <= set(shot.work)


# --- pages of engines and of findings, and the references

PROJECT = (ROOT / "pyproject.toml").read_text("utf-8")
SITE = (ROOT / "mkdocs.yml").read_text("utf-8")
FINDINGS = DOCS / "findings"
PROGRAMS = sorted(FINDINGS.glob("*.py"))
FOUND = (FINDINGS / "README.md").read_text(encoding="utf-8")


@pytest.mark.checkout
@pytest.mark.parametrize("name", [name for name in engine_names() if name in PROJECT])
def test_an_engine_has_a_page_that_the_site_lists(name):
    text = (DOCS / f"engines/{name}.md").read_text("utf-8")
    assert f'engine_pages.page("{name}")' in text
    assert f"engines/{name}.md" in SITE


@pytest.mark.checkout
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_what_is_sent_to_other_projects_runs_without_this_one_and_has_a_page(program):
    imported = set()
    for node in ast.walk(ast.parse(program.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            imported.add(node.module.partition(".")[0])
        elif isinstance(node, ast.Import):
            imported |= {one.name.partition(".")[0] for one in node.names}
    assert imported - {"importlib", "typing", "warnings"} == {program.stem.partition("_")[0]}
    page = program.with_name(program.stem.replace("_", "-") + ".md")
    assert f"    python {program.name}\n" in page.read_text(encoding="utf-8")
    assert program.read_text(encoding="utf-8").rstrip() in page.read_text(encoding="utf-8")
    assert f"({page.name})" in FOUND


@pytest.mark.checkout
@pytest.mark.parametrize("page", sorted(FINDINGS.glob("*-*.md")), ids=lambda path: path.stem)
def test_a_page_is_listed_with_the_version_that_it_is_of_and_shows_how_to_get_it(page):
    heading, _, text = page.read_text(encoding="utf-8").partition("\n")
    version = re.search(r"(?:pip install [\w-]+==|npm install [\w-]+@)([\d.]+)", text)[1]
    assert version in heading
    (row,) = (line for line in FOUND.splitlines() if f"({page.name})" in line)
    assert row.startswith(f"| {heading.removeprefix('# ').partition(':')[0]} |")
    assert f"findings/{page.name}" in SITE


REFERENCES = (DOCS / "references.md").read_text(encoding="utf-8")
CITED = re.compile(
    r"\b([A-Z][a-zé]+)(?:(?:,? (?:and|&) [A-Z][a-zé]+)| et al\.)?,?\s\(?((?:18|19|20)\d\d)\b"
)
MONTHS = "January February March April May June July August September October November December"
NO_AUTHORS = {"Somebody", "Version", "Python", *MONTHS.split()}
FOLDERS = ("engine", "ghostball", "reference_adapters", "validation", "reports", "benchmarks")


@pytest.mark.checkout
def test_whoever_is_cited_with_a_year_stands_on_the_page_of_references():
    found = {}
    for path in (path for folder in (*FOLDERS, "docs") for path in (ROOT / folder).rglob("*")):
        if path.suffix in (".py", ".md", ".toml") and path.name != "references.md":
            text = re.sub(r"\n[ #]*", " ", path.read_text(encoding="utf-8"))
            found |= dict.fromkeys(CITED.findall(text), path)
    cited = {one: path for one, path in found.items() if one[0] not in NO_AUTHORS}
    assert len(cited) > 30
    lines = REFERENCES.splitlines()
    for (author, year), path in cited.items():
        assert any(author in line and year in line for line in lines), (author, year, path)


@pytest.mark.checkout
def test_the_draft_of_the_paper_cites_what_its_bibliography_has():
    text = (ROOT / "paper/paper.md").read_text(encoding="utf-8")
    bibliography = (ROOT / "paper/paper.bib").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),", bibliography, re.MULTILINE)
    assert sorted(set(re.findall(r"@(\w+)", text.partition("# Summary")[2]))) == sorted(keys)
    assert len(text.split()) < 1200


@pytest.mark.checkout
def test_a_source_is_there_once_and_in_order():
    for table in REFERENCES.split("\n## ")[1:]:
        rows = re.findall(r"^\| (\w.*?)[,:]? ", table, re.MULTILINE)[1:]
        names = [row.casefold() for row in rows if row != "erdo100"]
        assert names == sorted(names)
    links = re.findall(r"\[doi:(\S+?)\]\((\S+?)\) ", REFERENCES)
    assert len(links) > 25
    assert len(set(links)) == len(links)
    assert all(link == f"https://doi.org/{doi}" for doi, link in links)


# --- `python -m docs.outputs`: blocks are run, outputs written once, and stale ones refused

PAGE = """Text.

<!-- run python
print("a | b")
-->
<!-- end -->

<!-- run shell as=console exit=3
secret=1  # hide
echo "took 5 ms" && exit 3
-->
<!-- end -->
"""


@pytest.mark.checkout
def test_outputs_stand_beneath_their_blocks_and_stay_where_durations_alone_differ(tmp_path):
    from docs.outputs import OutputError, write_outputs

    page = tmp_path / "page.md"
    page.write_text(PAGE, "utf-8")
    with pytest.raises(OutputError, match=r"page\.md.*make docs-outputs"):
        write_outputs([page], check=True)
    assert page.read_text("utf-8") == PAGE
    write_outputs([page], check=False)
    text = page.read_text("utf-8")
    assert "-->\n\na | b\n\n<!-- end -->" in text
    assert '```console\n$ echo "took 5 ms" && exit 3\ntook 5 ms\n```' in text
    later = text.replace("\ntook 5 ms", "\ntook 7.1 ms")
    page.write_text(later, "utf-8")
    write_outputs([page], check=True)
    assert page.read_text("utf-8") == later
    page.write_text(PAGE.replace("exit=3", "exit=0"), "utf-8")
    with pytest.raises(OutputError, match="ended with 3, expected 0"):
        write_outputs([page], check=False)
    with pytest.raises(OutputError, match=r"^a page must be a file in .* exist: \S+/nosuch\.md$"):
        write_outputs([page, tmp_path / "nosuch.md"], check=False)


@pytest.mark.checkout
def test_a_page_runs_again_only_if_it_or_its_inputs_have_changed(tmp_path, monkeypatch):
    from docs import outputs

    for name in ("docs", "code"):
        (tmp_path / name).mkdir()
    for name in ("pyproject.toml", "SECURITY.md", "code/module.py"):
        (tmp_path / name).touch()
    runs = tmp_path / "runs.txt"
    page = tmp_path / "docs/page.md"
    page.write_text("<!-- run shell\nprintf x >> runs.txt\n-->\n<!-- end -->\n", "utf-8")
    monkeypatch.setattr(outputs, "DOCS", tmp_path / "docs")
    monkeypatch.setattr(outputs, "BUILD", tmp_path / "build")
    monkeypatch.setattr(outputs, "CHECKED", tmp_path / "build/checked.json")
    monkeypatch.setattr(outputs, "READ", ("code",))
    found = []
    for change in (None, None, tmp_path / "code/module.py", page, tmp_path / "code/new.py"):
        if change is not None:
            with change.open("a", encoding="utf-8") as file:
                file.write("# changed\n")
        outputs._main(["page.md", "--check"])
        found.append(len(runs.read_text("utf-8")))
    outputs._main(["page.md", "--check", "--rerun"])
    assert [*found, len(runs.read_text("utf-8"))] == [1, 1, 2, 3, 4, 5]
