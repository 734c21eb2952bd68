"""Run scenes on engines, measure, judge and store the results; validate one engine."""
