"""Scenes x engines, run, measured, judged, stored; one engine held against them."""
