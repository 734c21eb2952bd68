"""Resting contact: islands of balls that friction holds together, their forces, their steps."""
