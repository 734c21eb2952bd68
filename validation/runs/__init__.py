"""Run one scene on one engine, check the result, and sample it."""
