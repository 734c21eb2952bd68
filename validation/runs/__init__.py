"""One engine plays one scene: the door through which results come in, and how they are sampled."""
