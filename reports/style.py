"""The style of all figures: each engine has the same colour, line, marker and name everywhere.

Colours of engines are those of Okabe and Ito (2008), which are distinct for common kinds of colour
blindness, and `BROWN`.
The configurations of an engine share a colour and differ by line and marker, so no meaning depends
on colour alone.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from ghostball.model.text_files import write_whole
from ghostball.reference_adapters.function import name_of_function
from ghostball.validation.results.quantities import scaled
from ghostball.validation.results.records import number_with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure, FigureBase

T = TypeVar("T")
LineStyle = str | tuple[float, tuple[float, ...]]

BLACK = "#000000"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
GREEN = "#009E73"
PURPLE = "#CC79A7"
ORANGE = "#E69F00"
SKY = "#56B4E9"
YELLOW = "#F0E442"
BROWN = "#7A4A00"  # a different hue; in grey, darker than all except black

GREY = "#6E6E6E"  # secondary text: contrast 5.1 : 1 to white, above the required 4.5 : 1
FAINT = "#C8C8C8"
CLOTH = "#F1F5F2"
CUSHION = "#8C9A91"

FAMILY_COLOURS = {
    "ghostball": BLACK,
    "pymunk": BLUE,
    "pybullet": VERMILLION,
    "paper-continuous": GREEN,
    "paper-discrete": PURPLE,
    "certified": BROWN,
    "pooltool": ORANGE,
    "billiards": SKY,
    "planck": SKY,
    "matter-js": VERMILLION,
    "cannon-es": ORANGE,
    "dart": ORANGE,
    "mujoco": SKY,
    "physx": SKY,
    "rapier": SKY,
    "newton": SKY,
    "box2d": YELLOW,
    "box2d3": YELLOW,
}
OTHER_COLOURS = (ORANGE, YELLOW)
"""Colours of users' engines, distinct from pymunk's blue: most users compare with pymunk."""

# Lengths of dashes and gaps in points. Through the gaps, the lines beneath are visible.
_VARIANTS: dict[str, tuple[LineStyle, str]] = {
    "": ("-", "o"),
    "contact_steps=exact": ((0.0, (1.2, 1.6)), "D"),
    "config=naive": ((0.0, (5.0, 2.5)), "^"),
}
_OTHER_VARIANTS: tuple[tuple[LineStyle, str], ...] = (
    ((0.0, (6.0, 2.0, 1.2, 2.0)), "v"),
    ((0.0, (3.0, 1.5)), "d"),
    ((0.0, (6.0, 2.0, 1.2, 2.0, 1.2, 2.0)), "X"),
)
# Styles of users' engines with default settings.
_OTHERS: tuple[tuple[LineStyle, str], ...] = (
    ((0.0, (8.0, 2.0)), "P"),
    ((0.0, (5.0, 1.5, 1.0, 1.5)), "<"),
    ((0.0, (2.0, 1.0)), ">"),
)
_FAMILY_LINES: dict[str, tuple[LineStyle, str]] = {
    "pymunk": ("-", "s"),
    "pybullet": ("-", "h"),
    "paper-continuous": ((0.0, (7.0, 2.0, 1.5, 2.0)), "p"),
    "paper-discrete": ((0.0, (3.5, 2.0)), "X"),
    "certified": ((0.0, (9.0, 1.5, 1.2, 1.5, 1.2, 1.5)), "*"),
    # Engines in JavaScript share colours with other engines, and differ by line and marker.
    "planck": ((0.0, (4.0, 1.0)), "<"),
    "matter-js": ((0.0, (4.0, 1.0, 1.2, 1.0)), ">"),
    "cannon-es": ((0.0, (2.0, 1.0)), "H"),
}

SIGNS = {
    **{"o": "●", "s": "■", "p": "⬟", "h": "⬢", "H": "⬣", "*": "★", "P": "✚", "X": "✖"},
    **{"D": "◆", "d": "⬧", "^": "▲", "v": "▼", "<": "◀", ">": "▶"},
}
"""Characters for the markers of engines, for the page."""

PNG_DPI = 130
FORMATS = ("png", "svg")

RC: Any = {
    "font.family": "DejaVu Sans",  # ships with matplotlib: the same everywhere
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.markersize": 5.0,
    "hatch.linewidth": 0.6,
    "text.hinting": "none",  # letters keep their shape, and drawing is a fifth faster
    "svg.hashsalt": "ghostball",  # else ids in the SVG are random
    "svg.fonttype": "path",
    "savefig.facecolor": "white",
}

# matplotlib's rcParams are global: two drawing threads would restore each other's settings.
_RC_LOCK = threading.RLock()


@dataclass(frozen=True)
class EngineStyle:
    """Style of an engine: name in legends, colour, line and marker."""

    name: str
    colour: str
    line: LineStyle
    marker: str
    ours: bool = False

    @property
    def line_width(self) -> float:
        """Line width [points]; Ghostball's line is a broad band beneath the others."""
        return 4.5 if self.ours else 1.3

    @property
    def line_alpha(self) -> float:
        """Opacity of a line."""
        return 0.28 if self.ours else 1.0


def split_label(label: str) -> tuple[str, str]:
    """Split an engine's label into family and settings: "pymunk:dt=1e-3" -> "pymunk", "dt=1e-3".

    The family of "my_package:MyEngine:dt=1e-3" is "my_package:MyEngine".
    """
    family, _, settings = label.partition(":")
    if settings and "=" not in (attribute := settings.partition(":"))[0]:
        family, settings = f"{family}:{attribute[0]}", attribute[2]
    return family, settings


def engine_name(label: str) -> str:
    """Return the name in figures: "pymunk:contact_steps=exact" -> "pymunk, exact steps"."""
    family, settings = split_label(label)
    words = [name_of_function(family) if ":" in family else family]
    for setting in filter(None, settings.split(",")):
        key, _, value = setting.partition("=")
        said = {"config": value, "contact_steps": f"{value} steps"}
        words.append(said.get(key, setting))
    return ", ".join(words)


def engine_style(label: str) -> EngineStyle:
    """Return the style of an engine; an unknown label gets a style from its hash."""
    family, settings = split_label(label)
    colour = FAMILY_COLOURS.get(family) or _pick(OTHER_COLOURS, family)
    if not settings and family in _FAMILY_LINES:
        line, marker = _FAMILY_LINES[family]
    elif not settings and family not in FAMILY_COLOURS:
        line, marker = _pick(_OTHERS, family)
    else:
        line, marker = _VARIANTS.get(settings) or _pick(_OTHER_VARIANTS, settings)
    ours = family == "ghostball"
    return EngineStyle(engine_name(label), colour, line, marker, ours)


def _pick(choices: tuple[T, ...], key: str) -> T:
    # Not `hash`: it differs from one process to the next.
    digest = hashlib.sha256(key.encode()).digest()
    return choices[digest[0] % len(choices)]


def format_length(metres: float | None) -> str:
    """Return a length with a suitable unit, to three digits: 0.00042 -> "420 µm"."""
    return _scaled(metres, "m")


def format_time(seconds: float | None) -> str:
    """Return a duration with a suitable unit, to three digits: 0.00042 -> "420 µs"."""
    return _scaled(seconds, "s")


def format_quantity(value: float | None, unit: str = "1") -> str:
    """Return a quantity to three digits with a suitable unit; integers have no decimals.

    With the unit "class", the text is the name of an accuracy class.
    """
    if value is None:
        return "–"
    if unit == "class":
        return number_with_unit(value, unit)
    if unit in ("s", "m"):
        return scaled(value, unit)
    if unit == "1/s" and value >= 1e3:
        scale, name = (1e6, " million/s") if value >= 1e6 else (1e3, " thousand/s")
        return f"{value / scale:.3g}{name}"
    whole = isinstance(value, int) or (value.is_integer() and abs(value) < 1e9)
    number = f"{value:.0f}" if whole else f"{value:.3g}"
    return number if unit == "1" else f"{number} {unit}"


def _scaled(value: float | None, unit: str) -> str:
    return "–" if value is None else scaled(value, unit)


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power_of_ten(exponent: int) -> str:
    """Return "10⁻⁶" in plain characters: matplotlib's superscripts are ten times slower to draw."""
    return "1" if exponent == 0 else "10" + str(exponent).translate(_SUPERSCRIPTS)


@contextmanager
def drawing() -> Iterator[None]:
    """Apply the style to all figures made and saved in the block; one thread at a time."""
    import matplotlib  # noqa: PLC0415 - importing `reports` must stay cheap

    with _RC_LOCK, matplotlib.rc_context(RC):
        yield


def new_figure(width: float, height: float, *, laid_out: bool = True) -> Figure:
    """Make an empty figure of the given size [inch], without any global state of pyplot.

    With `laid_out`, matplotlib computes the positions of axes and legends, which takes longer than
    drawing.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    layout: Literal["constrained"] | None = "constrained" if laid_out else None
    figure = Figure(figsize=(width, height), dpi=PNG_DPI, layout=layout)
    FigureCanvasAgg(figure)
    return figure


def set_title(figure: FigureBase, text: str) -> None:
    """Write the title of a figure at its upper left."""
    figure.suptitle(text, fontsize=10.5, fontweight="bold", x=0.01, ha="left")


def lay_out(figure: Figure) -> None:
    """Compute the layout once for all formats, because it takes longer than drawing."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")


def save_figure(
    figure: Figure, path: Path, description: str | None = None, *, endings: Sequence[str] = FORMATS
) -> list[Path]:
    """Write a figure as PNG and SVG beside each other; the same figure gives the same bytes.

    `path`: path without the ending.
    `description`: text for the metadata of the files.
    `endings`: endings of the files.

    Returns the files written.
    """
    if figure.get_layout_engine() is not None:
        lay_out(figure)
    targets = [path.with_name(f"{path.name}.{ending}") for ending in endings]
    for target in targets:
        save_one(figure, target, description)
    return targets


def save_one(figure: Figure, path: Path, description: str | None = None) -> None:
    """Write a figure in the format given by the ending of `path`, without dates.

    The file is written completely or not at all. `Figure.savefig` isn't used, because
    it draws everything twice.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.backends.backend_pdf import FigureCanvasPdf  # noqa: PLC0415
    from matplotlib.backends.backend_svg import FigureCanvasSVG  # noqa: PLC0415

    dpi, drawn = figure.dpi, BytesIO()
    canvas: Any  # its print_ methods have no types
    if path.suffix.lower() == ".svg":
        canvas = FigureCanvasSVG(figure)
        canvas.print_svg(
            drawn, metadata={"Date": None, "Creator": None, "Description": description}
        )
    elif path.suffix.lower() == ".pdf":
        canvas = FigureCanvasPdf(figure)
        canvas.print_pdf(drawn, metadata={"CreationDate": None, "Producer": None})
    else:
        canvas = FigureCanvasAgg(figure)
        canvas.print_png(drawn, metadata={"Software": None, "Description": description})
    figure.dpi = dpi  # some formats change it
    write_whole(path, drawn.getvalue())
