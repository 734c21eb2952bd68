"""The commands that play shots and say how right engines are."""
