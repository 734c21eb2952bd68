"""Commands that list scenes and engines, write reports, and start projects."""
