"""The shipped scenes and their limits; how one is found; random shots; commands to copy."""
