"""The pictures that the README and the documentation show, remade by `make gallery`."""
