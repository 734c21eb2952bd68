"""The texts of a figure."""


def texts_of(figure) -> str:
    """Return all texts of a figure, one per line."""
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))
