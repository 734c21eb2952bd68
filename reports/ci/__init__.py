"""What a CI reads or shows of a run: JUnit, notes beside lines, a summary."""
