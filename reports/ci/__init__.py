"""Formats for CI services: JUnit, annotations, a summary."""
