"""Why a run differs: where two part, what the difference is made of, the horizon of a shot."""
