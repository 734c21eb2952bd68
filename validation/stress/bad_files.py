"""Files that hold no scene: text that isn't TOML, a scene cut short, anything at all."""

from __future__ import annotations

from hypothesis import strategies as st

from validation.stress.plain_scenes import well_formed, written


@st.composite
def bad_syntax(draw: st.DrawFn) -> tuple[str, int]:
    """Return a scene whose text isn't TOML, and the line on which that shows."""
    text, _ = written(draw(well_formed(table=True)))
    lines = text.splitlines()
    keys = [n for n, line in enumerate(lines) if " = " in line]
    n = draw(st.sampled_from(keys))
    spoilt = draw(
        st.sampled_from(
            [
                lines[n].replace(" = ", " = = ", 1),
                lines[n].replace(" = ", " ", 1),
                lines[n] + " ]",
                lines[n] + " x",
                lines[n] + " \x01",
                lines[n].split(" = ")[0] + " =",
                lines[n].split(" = ")[0] + " = 01",
                lines[n].split(" = ")[0] + " = 1__0",
                lines[n].split(" = ")[0] + ' = "\\q"',
                lines[n].split(" = ")[0] + ' = "open',
                lines[n].split(" = ")[0] + " = 1979-13-41",
                "[open",
                "= 1",
            ]
        )
    )
    lines[n] = spoilt
    return "\n".join(lines) + "\n", n + 1


@st.composite
def cut_text(draw: st.DrawFn) -> tuple[bytes, bytes]:
    """Return a scene file, and what is left of it when it is cut short."""
    text, _ = written(draw(well_formed()))
    whole = text.replace("ball 1", "böll 1").encode()
    return whole, whole[: draw(st.integers(0, len(whole) - 1))]


ANYTHING = st.one_of(
    st.binary(max_size=200),
    st.text(max_size=200).map(lambda text: text.encode("utf-8", "surrogatepass")),
    st.text("[]{}=\"'.#\n\\ a1_-", max_size=100).map(str.encode),
)
"""Bytes that are no scene: any, any text, and what looks a little like TOML."""
