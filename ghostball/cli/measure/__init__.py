"""Commands that simulate shots and measure the errors of engines."""
