"""What comes next: times of impact of every pair for few balls, a broad phase by cells for many."""
