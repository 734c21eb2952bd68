"""The hook that compiles kernels into a wheel, only if requested."""

import importlib.util
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from ghostball.engine.library import cache
from ghostball.engine.library.entry import COMPILED
from ghostball.reference_adapters.stepping import cloth

pytest.importorskip("hatchling")
pytestmark = pytest.mark.checkout

ROOT = Path(__file__).parents[2]
NEEDS = ["numpy>=1.26", "matplotlib>=3.8", "pydantic>=2.12"]


@pytest.fixture
def hook(monkeypatch, tmp_path):
    specification = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(specification)
    monkeypatch.setitem(sys.modules, "hatch_build", module)
    specification.loader.exec_module(module)
    monkeypatch.setattr(sys, "path", [*sys.path])

    def compile_into(folder):
        (folder / "manifest.json").write_text("{}")
        (folder / "play.so").write_bytes(b"code")

    monkeypatch.setattr(module, "compile_into", compile_into)
    extras = {"compiler": ["numba>=0.62,<0.69"]}
    core = SimpleNamespace(dependencies=NEEDS, optional_dependencies=extras)
    metadata = SimpleNamespace(core=core)
    return module.KernelHook(str(ROOT), {}, None, metadata, str(tmp_path), "wheel", None)


def built(hook, version="standard"):
    data = {"pure_python": True, "force_include": {}}
    hook.initialize(version, data)
    return data


def test_a_wheel_that_is_not_asked_for_kernels_has_none_and_needs_no_compiler(hook, monkeypatch):
    for value in (None, "", "0"):
        if value is None:
            monkeypatch.delenv("GHOSTBALL_BUILD_KERNELS", raising=False)
        else:
            monkeypatch.setenv("GHOSTBALL_BUILD_KERNELS", value)
        assert hook.dependencies() == []
        assert built(hook) == {"pure_python": True, "force_include": {}}


def test_a_wheel_with_kernels_is_for_a_platform_and_every_python(hook, monkeypatch, tmp_path):
    monkeypatch.setenv("GHOSTBALL_BUILD_KERNELS", "1")
    assert hook.dependencies() == ["numpy>=1.26", "pydantic>=2.12", "numba>=0.62,<0.69"]
    monkeypatch.setattr(sys.modules["hatch_build"].sysconfig, "get_platform", lambda: PLATFORM)
    data = built(hook)
    assert data["tag"] == "py3-none-manylinux_2_17_x86_64"
    assert not data["pure_python"]
    inside = "ghostball/engine/library/shipped"
    assert data["force_include"] == {
        str(tmp_path / "kernels" / name): f"{inside}/{name}"
        for name in ("manifest.json", "play.so")
    }


PLATFORM = "linux-x86_64"


@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="interpreted kernels have no libraries")
@pytest.mark.usefixtures("hook")
def test_a_wheel_is_not_built_where_its_kernels_are_not_linked(monkeypatch, tmp_path, caplog):
    monkeypatch.setattr(cache, "directory", lambda: tmp_path / "cache")
    (tmp_path / "cache").mkdir()
    monkeypatch.setenv("CC", "nowhere/cc")
    with pytest.raises(RuntimeError, match="linking the kernels needs a C compiler"):
        sys.modules["hatch_build"].put_into(tmp_path / "kernels", cloth.needed()[:1])
    assert "`nowhere/cc` can't be run: No such file or directory" in caplog.text


def test_a_wheel_is_not_built_for_another_machine(hook, monkeypatch):
    monkeypatch.setenv("GHOSTBALL_BUILD_KERNELS", "1")
    monkeypatch.setenv("GHOSTBALL_BUILD_FOR", "arm64")
    with pytest.raises(RuntimeError, match="unset GHOSTBALL_BUILD_FOR"):
        built(hook)


def test_an_editable_installation_compiles_nothing(hook, monkeypatch):
    monkeypatch.setenv("GHOSTBALL_BUILD_KERNELS", "1")
    assert built(hook, "editable") == {"pure_python": True, "force_include": {}}


@pytest.mark.parametrize(
    ("platform", "machine", "libc", "tag"),
    [
        ("linux-aarch64", "aarch64", "glibc", "manylinux_2_17_aarch64"),
        ("linux-x86_64", "x86_64", "", "linux_x86_64"),  # such as Alpine's
        ("macosx-10.13-universal2", "arm64", "", "macosx_11_0_arm64"),
        ("macosx-10.13-universal2", "x86_64", "", "macosx_11_0_x86_64"),
        ("win-amd64", "AMD64", "", "win_amd64"),
    ],
)
def test_the_platform_is_named_as_wheels_name_it(hook, monkeypatch, platform, machine, libc, tag):
    module = sys.modules["hatch_build"]
    monkeypatch.delenv("MACOSX_DEPLOYMENT_TARGET", raising=False)
    monkeypatch.setattr(module.sysconfig, "get_platform", lambda: platform)
    monkeypatch.setattr(module.platform, "machine", lambda: machine)
    monkeypatch.setattr(module.platform, "libc_ver", lambda: (libc, ""))
    assert module.platform_tag() == tag
