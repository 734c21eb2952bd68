"""Code that several commands share: the terminal, progress bars, the settings of a project."""
