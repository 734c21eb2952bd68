"""The commands that say what moved, and keep what is accepted."""
