"""A run graded against the proof of its shot, by a tangent map of the grader's own."""
