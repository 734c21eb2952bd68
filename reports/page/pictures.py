"""Sections with pictures: ensembles, the paper's figures, laws of the game. The page holds them."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from markupsafe import Markup

from ghostball.reports.markdown_ensembles import ensembles_parts
from ghostball.reports.page.rendering import markdown
from ghostball.validation.results.store import Results

Pictures = Mapping[str, PurePosixPath]
"""PNG files that were drawn, by their name without the ending, relative to the page."""


def ensembles_html(results: Results, drawn: Pictures) -> Markup:
    """Return how perturbed shots end on each engine; "" where none were run."""
    html = Markup("")
    for scene, text in ensembles_parts(results):
        html += markdown(text, f"Ensemble of {scene}" if scene else "", wraps=True)
        picture = drawn.get(f"{scene}-ensemble")
        if picture is not None:
            html += _figure(results.path / picture, f"How perturbed shots of {scene} end")
    return html


def _figure(png: Path, caption: str) -> Markup:
    """Return a picture that lies within the page, since the page may be sent without its folder."""
    data = b64encode(png.read_bytes()).decode()
    return Markup(
        '<figure class="picture"><img alt="%s" src="data:image/png;base64,%s">'
        "<figcaption>%s</figcaption></figure>"
    ) % (caption, data, caption)
