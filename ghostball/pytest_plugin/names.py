"""Constants of the plugin's modules, here so that they need not import the plugin itself."""

PREFIX = "ghostball::"
"""Start of the ids of all tests of Ghostball."""

TIME_LIMIT = 600.0
"""Default time limit for a scene [s], as in `ghostball validate`."""
