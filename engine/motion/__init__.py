"""How a ball moves until something happens to it, and what it meets on its way."""
