"""What all commands share: options, the terminal, progress, the settings of a project."""
