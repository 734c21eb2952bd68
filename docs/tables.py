"""Tables of the documentation that show the code; each function returns Markdown."""

from __future__ import annotations

import inspect
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from benchmarks.synthetic_tracks import EXAMPLE_PHYSICS
from ghostball.model import POOL_BALL_MASS, POOL_BALL_RADIUS, Ball, Physics, Rack, Strike, Table
from ghostball.model.features import Capability, Feature
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS
from ghostball.model.scene import stroke_of
from ghostball.reference_adapters import ReferenceEngine, engine_class, engine_names
from ghostball.reports.accuracy import CLASSES
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.scenes.library import select

NONE = Capability("none")


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown. The first head must have a text, or no table would be shown."""
    assert heads[0]
    lines = (heads, ["---"] * len(heads), *rows)
    return "\n".join(" | ".join(cell.replace("|", "\\|") for cell in cells) for cells in lines)


def scenes() -> str:
    """Return the shipped scenes."""
    rows = ((f"`{scene.name}`", scene.title, ", ".join(scene.tags)) for scene in select())
    return table(("scene", "what it tests", "tags"), rows)


def fields(part: type[Ball | Physics | Rack | Strike | Table]) -> str:
    """Return the fields of a part of a scene: defaults and meaning."""
    rows = []
    for name, field in part.model_json_schema()["properties"].items():
        default = field.get("default")
        choices = ", ".join(f"`{choice}`" for choice in field.get("enum", ()))
        meaning = "; ".join(filter(None, (field.get("description", ""), choices)))
        rows.append((f"`{name}`", "" if default is None else f"`{default}`", meaning))
    return table(("field", "default", "meaning"), rows)


def squirt() -> str:
    """Return the squirt of a level cue, seen from above, by offset and model."""
    shafts = (("end-mass", 0.0061), ("end-mass", 0.0098), ("end-mass", 0.0127))
    models = (*shafts, ("alciatore", 0.0098))
    rows = []
    for left, up in ((0.1, 0.0), (0.2, 0.0), (0.3, 0.0), (0.4, 0.0), (0.3, 0.3), (0.3, -0.3)):
        angles = []
        for model, end_mass in models:
            fields = {"offset_left": left, "offset_up": up, "squirt": model, "end_mass": end_mass}
            strike = Strike(speed=3.0, direction=0.0, **fields)
            x, y, _ = stroke_of(strike, POOL_BALL_RADIUS, POOL_BALL_MASS).velocity
            angles.append(f"{math.degrees(math.atan2(-y, x)):.2f}")
        rows.append((f"{left:g}", f"{up:g}", *angles))
    heads = (f"`{model}`, {1e3 * end_mass:g} g [degrees]" for model, end_mass in models)
    return table(("`offset_left`", "`offset_up`", *heads), rows)


def metrics() -> str:
    """Return the metrics."""
    rows = ((f"`{x.name}`", x.unit, x.meaning, x.compares or "nothing") for x in METRICS.values())
    return table(("metric", "unit", "meaning", "compared with"), rows)


def classes() -> str:
    """Return the classes of accuracy, from the best to the worst."""
    rows = (
        (f"**{kind}**", "" if look.short == kind else look.short, look.meaning)
        for kind, look in CLASSES.items()
    )
    return table(("class", "in tables", "meaning"), rows)


def engines() -> str:
    """Return how each engine supports each feature of the physics."""
    marks = {"exact": "exact", "approximate": "approx.", "none": "–"}
    shipped = [any_engine(name).capabilities for name in engine_names()]
    rows = (
        (feature.value, *(marks[known.get(feature, NONE).support] for known in shipped))
        for feature in Feature
    )
    return table(("physics", *(f"`{name}`" for name in engine_names())), rows)


def any_engine(name: str) -> ReferenceEngine:
    """Return an engine, installed or not: its declarations are the same everywhere."""
    make: Any = engine_class(name)
    made: ReferenceEngine = make()
    return made


def shapes() -> str:
    """Return how each engine supports pockets, polygons and posts."""
    rows = []
    for name in engine_names():
        known = any_engine(name).capabilities[Feature.POCKETS]
        said = {"exact": "exactly", "approximate": "approximately", "none": "unsupported"}
        rows.append((f"`{name}`", said[known.support], known.how))
    return table(("engine", "support", "how"), rows)


def laws() -> str:
    """Return the impact laws: the parameters and the source of each."""
    rows = (
        (f"`{law.name}`", what, law.source, ", ".join(f"`{name}`" for name in law.uses))
        for what, laws in (("ball-ball", BALL_LAWS), ("ball-cushion", CUSHION_LAWS))
        for law in laws
    )
    return table(("law", "collision", "source", "parameters"), rows)


def fitted_example(path: str) -> str:
    """Return the values fitted to the example's tracks, and the true values."""
    text = Path(path).read_text(encoding="utf-8")
    errors = dict(re.findall(r"^(\w+) = .* # \+- (\S+)$", text, re.MULTILINE))
    rows = []
    for name, value in tomllib.loads(text)["physics"].items():
        if name in errors:
            true, error = getattr(EXAMPLE_PHYSICS, name), float(errors[name])
            off = f"{(value - true) / error:+.1f}"
            rows.append((f"`{name}`", f"{true:g}", f"{value:g} ± {errors[name]}", off))
    return table(("field", "true value", "fitted value", "difference in standard errors"), rows)


def command_line() -> str:
    """Return the help of every command, from the parsers that read their options."""
    typer = [sys.executable, "-m", "typer", "ghostball.cli", "utils", "docs", "--name", "ghostball"]
    text = subprocess.run(typer, capture_output=True, text=True, check=True).stdout
    return text.partition("\n")[2]


def names(section: str) -> str:
    """Return the public names of a section of `api.md`, with the first line of each docstring."""
    page = Path("docs/api.md").read_text(encoding="utf-8")
    (part,) = re.findall(rf"^## {section}\n(.*?)(?=^## |\Z)", page, re.M | re.S)
    rows = []
    for where in re.findall(r"^::: (\S+)", part, re.M):
        module, _, name = where.rpartition(".")
        said = inspect.getdoc(getattr(import_module(module), name)) or ""
        rows.append((f"`{name}`", said.partition("\n")[0]))
    return table(("name", "description"), rows)
