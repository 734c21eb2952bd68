"""Short example engines to start from; they aren't installed as engines."""
