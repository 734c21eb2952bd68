"""The shipped scenes and their limits, finding scenes, random scenes, and commands to copy."""
