"""Sections with pictures: ensembles, the paper's figures, laws of the game. The page holds them."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from markupsafe import Markup

from ghostball.reports.markdown_ensembles import ensembles_parts
from ghostball.reports.page.rendering import markdown, render
from ghostball.validation.results.store import Results

Pictures = Mapping[str, PurePosixPath]
"""PNG files that were drawn, by their name without the ending, relative to the page."""

CAPTIONS = {
    "chaos": "Shots that begin almost alike part exponentially, as the tangent map says",
    "physics-deflection": "The 30 degree rule: deflection of a rolling cue ball by a cut",
    "physics-throw": "Throw of the object ball, against cut angle and against side spin",
    "paper-figure-1": "The paper's Figure 1: a break of 7 balls at four instants",
    "paper-figure-2": "The paper's Figure 2: clipping, and the same instants without it",
    "paper-figure-3": "The paper's Figure 3: a ball meets a cushion",
    "paper-figure-4": "The paper's Figure 4: head-on against slightly skewed",
    "paper-section-6-1": "The paper's section 6.1: how balls turn, and its own rule for it",
    "paper-section-6-2": "The paper's section 6.2: a ball that slips",
    "paper-section-6-3": "The paper's section 6.3: air, and restitution",
    "paper-section-6-4": "The paper's section 6.4: a ball that flies",
}


def pictures_html(results: Results, drawn: Pictures) -> Markup:
    """Return the figures of the whole run that were drawn."""
    return render(
        "pictures.html",
        pictures=[
            _figure(results.path / drawn[name], caption)
            for name, caption in CAPTIONS.items()
            if name in drawn
        ],
    )


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
