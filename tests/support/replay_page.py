"""A page of replays and nothing else: each scene is mounted as it is opened by `#scene=NAME`."""

import json
from pathlib import Path

from reports.page.replay_assets import replay_script, replay_style
from reports.page.replay_data import scene_data
from reports.shots import load_shot
from validation.store import ResultsFolder

_PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Replays</title>
<link rel="icon" href="data:,">
<style>
:root {{ color-scheme: light dark; --cloth: #f1f5f2; --cushion: #8c9a91; --ink: #1a1f1c;
  --muted: #55605a; --paper: #ffffff; --accent: #0b57d0; }}
@media (prefers-color-scheme: dark) {{ :root {{ --cloth: #1d2a24; --cushion: #55655c;
  --ink: #e8eeea; --muted: #a9b5ae; --paper: #121614; --accent: #8ab4f8; }} }}
@media print {{ :root {{ color-scheme: light; --cloth: #f1f5f2; --ink: #000000;
  --paper: #ffffff; }} }}
body {{ font: 16px/1.45 system-ui, sans-serif; margin: 0 auto; padding: 1rem; max-width: 62rem;
  background: var(--paper); color: var(--ink); }}
{style}
</style>
{scenes}
<script>{script}</script>
<script>
const open = () => {{
  const name = decodeURIComponent(location.hash.slice("#scene=".length));
  for (const element of document.querySelectorAll(".replay")) {{
    const mine = element.dataset.replay === `replay-${{name}}`;
    element.hidden = !mine;
    if (!mine || element.ghostball) continue;
    Ghostball.mountReplay(
      element, JSON.parse(document.getElementById(element.dataset.replay).textContent));
  }}
}};
addEventListener("hashchange", open);
open();
</script>
"""


def write_replay_page(results_folder: Path) -> Path:
    """Write `report.html` with the replay of every scene of a results folder."""
    results = ResultsFolder.load(results_folder)
    scenes = "".join(_scene(results, name) for name in results.scene_names)
    path = results_folder / "report.html"
    page = _PAGE.format(style=replay_style(), script=replay_script(), scenes=scenes)
    path.write_text(page, encoding="utf-8")
    return path


def _scene(results: ResultsFolder, name: str) -> str:
    data = json.dumps(scene_data(load_shot(results, name)), allow_nan=False)
    data = data.replace("<", "\\u003c")
    return (
        f'<script type="application/json" id="replay-{name}">{data}</script>\n'
        f'<div class="replay" data-replay="replay-{name}" hidden></div>\n'
    )
