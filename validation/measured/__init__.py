"""Measured billiards: published measurements on real tables, and how engines reproduce them."""
