"""What engines that step share: when a step should end, the cloth between steps, equal steps."""
