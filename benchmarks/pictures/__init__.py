"""Draw the pictures of the README and the documentation; `make gallery` writes them."""
