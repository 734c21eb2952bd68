"""What a CI reads or shows of a run: JUnit, SARIF, notes beside lines, a summary."""
