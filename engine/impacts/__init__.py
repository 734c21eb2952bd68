"""What impacts do: one in its contact frame (`impact`), several that share a ball, the laws."""
