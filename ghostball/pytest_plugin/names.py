"""Constants that the plugin's modules use without importing the plugin itself."""

PREFIX = "ghostball::"
"""Start of the ids of all tests of Ghostball."""

TIME_LIMIT = 600.0
"""Default time limit for a scene [s], as in `ghostball validate`."""
