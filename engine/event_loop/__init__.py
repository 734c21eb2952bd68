"""The loop from event to event: what comes next, what it does, what is recorded of it."""
