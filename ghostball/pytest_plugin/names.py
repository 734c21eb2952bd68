"""What the plugin's modules share, in a module of its own: so none of them imports the plugin."""

PREFIX = "ghostball::"
"""What the ids of all these tests begin with."""

TIME_LIMIT = 600.0
"""Seconds that a scene may take, unless another limit is given; as in `ghostball validate`."""
