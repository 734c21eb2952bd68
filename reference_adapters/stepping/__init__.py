"""Shared code of the adapters of time-stepping engines: step ends, cloth friction, pockets."""
