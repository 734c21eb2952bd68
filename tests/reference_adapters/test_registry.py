"""Engines by name and spec: lists, settings, and one clear error for each mistake."""

import importlib
import importlib.metadata
import subprocess
import sys
from pathlib import Path

import pytest

from ghostball.reference_adapters import (
    EngineError,
    EngineUnavailableError,
    engine_class,
    engine_names,
    make_engine,
    parse_spec,
)

SHIPPED = ("ghostball", "certified", "paper-continuous", "paper-discrete", "pybullet", "pymunk")

# The engine of a foreign package; tests replace the parts in single braces.
FOREIGN = """
from typing import Annotated, Literal
from pydantic import Field
from ghostball.reference_adapters.base import EngineBase, EngineSettings

class Settings(EngineSettings):
    dt: Annotated[float, Field(gt=0)] = 1e-3
    iterations: int = 10
    warm: bool = True
    mode: Literal["native", "landed"] = "native"

class Engine(EngineBase):
    name = "{name}"
    Settings = Settings
    capabilities = {{}}

    @classmethod
    def unavailable(cls):
        return {reason!r}

    def simulate(self, scene, *, record="rest"):
        raise NotImplementedError
"""


class ForeignPackages:
    """Packages that declare an engine, installed during a test."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def install(self, package: str, source: str) -> None:
        module = package.replace("-", "_")
        (self.folder / f"{module}.py").write_text(source)
        metadata = self.folder / f"{module}-1.0.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1\n")
        entry_points = f"[ghostball.engines]\nforeign = {module}:Engine\n"
        (metadata / "entry_points.txt").write_text(entry_points)
        importlib.invalidate_caches()


@pytest.fixture
def packages(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    before = set(sys.modules)
    yield ForeignPackages(tmp_path)
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def foreign(reason=None, name="foreign"):
    return FOREIGN.format(reason=reason, name=name)


# --- names ------------------------------------------------------------------------------------


def test_ours_is_listed_first_and_the_shipped_ones_are_all_there():
    names = engine_names()
    assert names[0] == "ghostball"
    assert set(SHIPPED) <= set(names)


def test_listing_imports_no_engine():
    # Listing must not load entry points: a broken or slow engine would affect every user.
    code = (
        "import sys; from ghostball.reference_adapters import engine_names; engine_names();"
        "print([m for m in ('pymunk', 'pybullet', 'numba') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_foreign_engine_joins_by_its_entry_point(packages):
    packages.install("some-engine", foreign())
    assert "foreign" in engine_names()
    assert make_engine("foreign:dt=2e-3").settings.dt == 2e-3


def test_a_module_that_fails_to_import_is_named_with_the_reason(packages):
    packages.install("some-engine", "raise RuntimeError('no licence file')")
    assert "foreign" in engine_names()
    with pytest.raises(EngineUnavailableError) as caught:
        engine_class("foreign")
    for part in ("`foreign`", "some-engine", "no licence file", "RuntimeError"):
        assert part in str(caught.value)


def test_the_package_that_is_there_now_is_named(packages):
    packages.install("some-engine", "raise RuntimeError('no licence file')")
    with pytest.raises(EngineUnavailableError, match="of package `some-engine`"):
        engine_class("foreign")
    metadata = packages.folder / "some_engine-1.0.dist-info" / "METADATA"
    metadata.write_text("Metadata-Version: 2.1\nName: its-fork\nVersion: 1\n")
    with pytest.raises(EngineUnavailableError, match="of package `its-fork`"):
        engine_class("foreign")


def test_an_engine_that_can_be_imported_is_loaded_without_its_metadata(packages, monkeypatch):
    packages.install("quick-engine", foreign())
    assert "foreign" in engine_names()  # these are kept

    def read(_):
        raise AssertionError

    monkeypatch.setattr(importlib.metadata.Distribution, "metadata", property(read))
    assert engine_class("foreign").name == "foreign"


def test_an_engine_that_calls_itself_otherwise_is_refused(packages):
    packages.install("some-engine", foreign(name="other"))
    with pytest.raises(EngineUnavailableError, match="has the name 'other'"):
        engine_class("foreign")


def test_a_name_claimed_by_two_packages_is_refused(packages):
    packages.install("one-engine", foreign())
    packages.install("two-engine", foreign())
    assert engine_names().count("foreign") == 1
    with pytest.raises(
        EngineError,
        match=r"provided by two packages: one_engine:Engine, "
        r"two_engine:Engine",
    ):
        engine_class("foreign")


@pytest.mark.parametrize("name", ["ghostball", "pymunk"])
def test_no_other_engine_may_have_the_name_of_an_installed_one(packages, name):
    # References, limits and results depend on the name, and a crash would look like Ghostball's
    # bug.
    packages.install("some-engine", foreign(name=name))
    with pytest.raises(EngineError, match=f"must not be '{name}'") as caught:
        make_engine("some_engine:Engine")
    assert not isinstance(caught.value, EngineUnavailableError)
    ours = "ghostball.reference_adapters.ghostball:GhostballEngine"
    assert engine_class(ours) is engine_class("ghostball")


def test_an_engine_that_cannot_run_here_says_why(packages):
    packages.install("some-engine", foreign(reason="libfoo is missing; run `apt install libfoo`"))
    engine_class("foreign")  # the class still has settings and capabilities
    with pytest.raises(EngineUnavailableError, match=r"`foreign` is unavailable.*apt install"):
        make_engine("foreign")


def test_an_unknown_engine_lists_the_known_and_the_closest():
    with pytest.raises(EngineError) as caught:
        make_engine("pymonk")
    assert not isinstance(caught.value, EngineUnavailableError)
    for part in ("'pymonk'", "Did you mean `pymunk`?", *SHIPPED):
        assert part in str(caught.value)


# --- specs ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("pymunk", ("pymunk", {})),
        ("pymunk:dt=1e-3", ("pymunk", {"dt": "1e-3"})),
        (
            "pymunk:dt=1e-3,contact_steps=exact",
            ("pymunk", {"dt": "1e-3", "contact_steps": "exact"}),
        ),
        (" pymunk : dt = 1e-3 ", ("pymunk", {"dt": "1e-3"})),
        ("pymunk:file=a:b=c", ("pymunk", {"file": "a:b=c"})),
        ("my.package:Mine", ("my.package:Mine", {})),
        ("mine : Mine.Inner : dt = 1", ("mine:Mine.Inner", {"dt": "1"})),
    ],
)
def test_a_spec_is_split_into_name_and_settings(spec, expected):
    assert parse_spec(spec) == expected


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("", "name must be given"),
        (":dt=1", "name must be given"),
        ("pymunk:", "must be `key=value`, got ''"),
        ("my-engine:simulate", "no engine has the name 'my-engine', and no Python module"),
        ("my engine:simulate", "no engine has the name 'my engine', and no Python module"),
        ("cannon-es:dt", "must be `key=value`, got 'dt'"),
        ("pymunk:dt", "must be `key=value`, got 'dt'"),
        ("pymunk:dt=", "must be `key=value`, got 'dt='"),
        ("pymunk:=1", "must be `key=value`, got '=1'"),
        ("pymunk:dt=1,,mode=a", "must be `key=value`, got ''"),
        ("pymunk:dt=1,dt=2", "`dt` must be given once"),
    ],
)
def test_a_malformed_spec_says_what_is_wrong(spec, message):
    with pytest.raises(EngineError, match=message):
        parse_spec(spec)


# --- settings ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "dt"), [("1/60", 1 / 60), ("1/240", 1 / 240), ("1e-3", 1e-3)])
def test_a_step_may_be_a_fraction(text, dt):
    assert make_engine(f"pymunk:dt={text}").settings.dt == dt


@pytest.mark.parametrize("text", ["1/0", "1/2/3", "1/", "/60", "a/b", "-1/60"])
def test_a_fraction_that_is_no_positive_number_is_refused(text):
    with pytest.raises(EngineError, match="`dt` of engine `pymunk` must"):
        make_engine(f"pymunk:dt={text}")


def test_a_whole_number_may_not_be_a_fraction():
    with pytest.raises(EngineError, match="`iterations` of engine `pymunk` must"):
        make_engine("pymunk:iterations=60/2")


def test_values_are_read_as_the_type_of_their_setting(packages):
    packages.install("some-engine", foreign())
    settings = make_engine("foreign:dt=1e-4,iterations=30,warm=false,mode=landed").settings
    assert (settings.dt, settings.iterations, settings.warm, settings.mode) == (
        1e-4,
        30,
        False,
        "landed",
    )
    assert type(settings.iterations) is int


@pytest.mark.parametrize(
    ("setting", "parts"),
    [
        ("dt=0", ["`dt`", "must be greater than 0", "'0'"]),
        ("dt=nan", ["`dt`", "finite", "'nan'"]),
        ("dt=inf", ["`dt`", "finite", "'inf'"]),
        ("dt=fast", ["`dt`", "must be a valid number", "'fast'"]),
        ("iterations=2.5", ["`iterations`", "must be a valid integer", "'2.5'"]),
        ("mode=slow", ["`mode`", "must be 'native' or 'landed'", "'slow'"]),
        (
            "step=1e-3",
            ["`step`", "not a setting of engine `foreign`", "'1e-3'", "time step is `dt`"],
        ),
        ("iteration=3", ["Did you mean `iterations`?"]),
        ("dt=-1,iterations=x", ["`dt`", "`iterations`"]),
    ],
)
def test_a_wrong_setting_names_setting_rule_value_and_the_known_ones(packages, setting, parts):
    packages.install("some-engine", foreign())
    with pytest.raises(EngineError) as caught:
        make_engine(f"foreign:{setting}")
    for part in (*parts, "dt=0.001, iterations=10, warm=True, mode=native"):
        assert part in str(caught.value)


def test_a_setting_that_is_left_to_the_engine_is_called_unset():
    # Users must not be advised to write `dt=None`, which is rejected.
    with pytest.raises(EngineError, match="`dtt` is not a setting") as caught:
        make_engine("pymunk:dtt=1e-3")
    assert "dt unset" in str(caught.value)
    assert "None" not in str(caught.value)


def test_a_package_that_exits_when_imported_is_named(packages):
    packages.install("quitter", "raise SystemExit(0)\n")
    with pytest.raises(EngineUnavailableError, match=r"`foreign` can't be imported.*SystemExit"):
        engine_class("foreign")


def test_an_interrupt_before_what_is_printed_is_caught_stays_one(packages, monkeypatch):
    """This was once reported as the engine's own failure, and the run continued."""

    def interrupted(**_):
        raise KeyboardInterrupt

    packages.install("some-engine", foreign())
    monkeypatch.setattr("ghostball.reference_adapters.registry.captured", interrupted)
    with pytest.raises(KeyboardInterrupt):
        make_engine("foreign")
