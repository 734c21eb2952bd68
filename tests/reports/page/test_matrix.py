"""Fails where the matrix of engines by scenes hides why a cell is what it is."""

from page_texts import section


def test_the_matrix_says_why_without_colour_and_without_a_pointer(html):
    text = section(html, "matrix")
    link = "#scene=stop&amp;engine=ghostball&amp;engine=pymunk%3Aconfig%3Dnaive"
    cell = f' class="acc-cm"><a href="#scene=stop" data-view="{link}">90 mm <span class="mark">✗'
    assert f'{cell}</span><span class="why">' in text
    assert (
        "stop on pymunk:config=naive: centimetres: the farthest ball is 90 mm from where it "
        "should be; worse than its limits: rest_error_max breaks its limit" in text
    )
    assert "<code>pybullet</code> not representable: no table | with legs" in text
    assert "did not finish: division by zero" in text
