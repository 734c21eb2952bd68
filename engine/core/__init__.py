"""What every kernel stands on: state, the decorator, tolerances, kinds of events."""
