"""What a run found, as it is stored: records, folders, files written whole, the environment."""
