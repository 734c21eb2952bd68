"""Foreign engines behind one protocol, each `Scene` -> `Result`."""
