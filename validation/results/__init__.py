"""Store the results of a run: records, folders, files written atomically, the environment."""
