"""Enclosures and certificates: exact numbers, and an exact JSON form."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given, strategies as st
from shots import ball, scene_of

from ghostball.model import EventKind
from ghostball.reference_adapters.certified import Certificate, Choice, Enclosure, certify

enclosures = st.builds(
    Enclosure,
    st.integers(-(2**300), 2**300),
    st.integers(-400, 20),
    st.integers(0, 2**30),
    st.integers(-500, 20),
)


@given(enclosures)
def test_an_enclosure_reads_back_to_the_same_integers(enclosure):
    assert Enclosure.parse(enclosure.to_text()) == enclosure


def test_ends_and_width_of_an_enclosure():
    # 3/8 +- 1/16
    e = Enclosure(3, -3, 1, -4)
    assert (e.mid, e.rad) == (Fraction(3, 8), Fraction(1, 16))
    assert (e.lower, e.upper, e.width) == (Fraction(5, 16), Fraction(7, 16), 0.125)
    assert e.contains(Fraction(5, 16))
    assert e.contains(0.4375)
    assert not e.contains(0.4376)


def test_a_float_is_the_nearest_to_the_middle():
    # 1 + 2^-53 + 2^-200 is just above the middle between two doubles.
    middle = (1 << 200) + (1 << 147) + 1
    assert float(Enclosure(middle, -200, 1, -300)) == 1.0 + 2.0**-52
    assert float(Enclosure(middle - 2, -200, 1, -300)) == 1.0


def test_a_certificate_reads_back_whole():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.1)), ball((0.5, 0.0)))
    certificate = certify(scene, motion=True)
    assert certificate.proved
    text = certificate.to_json()
    again = Certificate.from_json(text)
    assert again.to_json() == text
    assert again.events == certificate.events
    assert again.positions == certificate.positions
    assert again.segments is not None
    assert certificate.segments is not None
    assert [k.tolist() for k in again.segments] == [k.tolist() for k in certificate.segments]


def test_segments_are_read_with_their_columns():
    """Segments of a ball in air have more columns and must not be read as other segments."""
    air = scene_of(ball((0.0, 0.0), (1.0, 0.1)), air_drag=0.1)
    flat = scene_of(ball((0.0, 0.0), (1.0, 0.1)))
    in_air, plain = (certify(scene, motion=True) for scene in (air, flat))
    for certificate, width in ((in_air, 109), (plain, 14)):
        again = Certificate.from_json(certificate.to_json())
        assert again.columns == certificate.columns
        assert len(again.columns) == width
        assert again.segments[0].tobytes() == certificate.segments[0].tobytes()
        assert again.starts == certificate.starts == ((0, len(again.segments[0]) - 1),)
    assert in_air.columns[14:20] == ("x2", "y2", "z2", "wx2", "wy2", "x3")
    assert in_air.columns[-1] == "wy20"


def test_a_choice_is_described_by_names():
    ids = ("cue", "eight")
    assert Choice(EventKind.BALL_BALL, 0, 1).describe(ids) == 'ball-ball "cue" with "eight"'
    assert Choice(EventKind.BALL_CUSHION, 1, 2).describe(ids) == 'ball-cushion "eight" with bottom'
    assert Choice(EventKind.ROLL_TO_REST, 0, -1).describe(ids) == 'roll-to-rest "cue"'
