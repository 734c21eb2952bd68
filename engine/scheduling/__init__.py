"""What comes next: bounds of every pair for few balls, a grid of cells for many."""
