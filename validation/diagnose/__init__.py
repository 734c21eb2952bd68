"""Why a run differs from the reference: the first difference, its causes, its energy losses."""
