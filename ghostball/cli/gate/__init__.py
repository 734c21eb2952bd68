"""Commands that detect changes of an engine: `regress`, `accept` and `diff`."""
