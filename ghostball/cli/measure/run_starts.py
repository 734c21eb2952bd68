"""`ghostball run --starts`: simulate a file of initial states or strokes, or a shard of it."""

from __future__ import annotations

import json
import time
from pathlib import Path

from rich.markup import escape

from ghostball.cli.measure.commands import RunOptions
from ghostball.cli.options import TextOrJson
from ghostball.cli.shared.calls import refuse_given
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.single_shots import compile_first
from ghostball.cli.shared.tables import facts_table
from ghostball.cli.shared.terminal import say, stdout
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.cluster import cluster_at
from ghostball.validation.results.files import write_files
from ghostball.validation.runs.starts_files import Shard, parquet_of, play_file
from ghostball.validation.scenes.library import find_scene

FOLDER = Path("shots")
"""Default folder of the Parquet files, outside results folders, which hold only results."""


def play_starts(asked: RunOptions, starts: Path) -> ExitStatus:
    """Simulate the shots, write their outcomes to a Parquet file, and print a summary.

    Returns exit status 1 if a shot stopped before its end, for example at the limit of events.
    """
    why = "`--starts` simulates shots on Ghostball's engine and writes their outcomes"
    refuse_given(asked.context, why, "engine", "record", "plot", "expect_hash", "time_limit")
    shard = Shard.parse(asked.shard or "1/1")
    folder = asked.out or FOLDER
    scene = find_scene(asked.scene)
    compile_first([scene], OURS)
    began = time.perf_counter()
    with cluster_at(asked.cluster) as cluster, counting("shots") as progress:
        frame = play_file(scene, starts, shard, cluster=cluster, progress=progress)
    seconds = time.perf_counter() - began
    file = folder / shard.file_name("shots")
    write_files({file: parquet_of(frame)}, "Choose another `--out`")
    ended = dict(frame["status"].value_counts().sort("status").iter_rows())
    facts = {"file": str(file), "shots": len(frame), "ended": ended, "seconds": round(seconds, 3)}
    if asked.form is TextOrJson.JSON:
        print(json.dumps(facts))
    else:
        how = ", ".join(f"{status} {count}" for status, count in ended.items())
        plain = {"file": str(file), "shots": str(len(frame)), "ended": how}
        stdout().print(facts_table(plain | {"run time": f"{seconds:.3g} s"}))
    if unfinished := len(frame) - sum(ended.get(one, 0) for one in ("rest", "t-max")):
        where = f"see the column `status` of {escape(str(file))}"
        say(f"[bold red]{unfinished} shots did not finish:[/] {where}")
        return ExitStatus.CHECK_FAILED
    return ExitStatus.PASSED
