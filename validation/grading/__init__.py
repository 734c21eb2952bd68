"""Compare a run with the certified result of its shot, with an independent tangent map."""
