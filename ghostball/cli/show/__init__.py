"""The commands that show what is there, and write files to begin from."""
