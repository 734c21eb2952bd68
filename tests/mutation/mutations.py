"""The bugs that are planted in copies of our packages, and what catches each.

They stand in `bugs/`, by the package that they are planted in. Each is one text of one file, such
as an engine might really have, and most are small: what they leave wrong is a part in a billion, or
shows in one kind of shot alone.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from mutants import Mutation

MUTATIONS = tuple(
    Mutation(**bug)
    for path in sorted(Path(__file__).with_name("bugs").glob("*.toml"))
    for bug in tomllib.loads(path.read_text("utf-8"))["bug"]
)
