"""Measured billiards: published facts about real tables, and the operator of each measurement."""
