"""The packages as names to import."""

from __future__ import annotations

import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import ghostball

COMMANDS = {"cli", "pytest_plugin"}
"""What nobody imports from."""

PACKAGES = [one.name for one in pkgutil.iter_modules(ghostball.__path__) if one.ispkg]


@pytest.mark.parametrize("name", ["", *sorted({*PACKAGES} - COMMANDS)])
def test_no_name_of_a_package_hides_a_module_of_it(name):
    """`import engine.simulate as m` gave a function, while there was a module of that name."""
    package = f"ghostball.{name}".rstrip(".")
    loaded = importlib.import_module(package)
    for module in pkgutil.iter_modules(loaded.__path__):
        named = vars(loaded).get(module.name)
        assert named is None or named.__name__ == f"{package}.{module.name}"


def test_each_name_on_the_page_of_python_is_imported_from_ghostball():
    page = (Path(__file__).parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
    names = [where.rpartition(".")[2] for where in re.findall(r"^::: (\S+)", page, re.M)]
    assert len(names) > 20
    assert [name for name in names if name not in ghostball.__all__] == []
