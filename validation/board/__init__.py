"""The board: every engine and configuration on the questions that distinguish engines."""
