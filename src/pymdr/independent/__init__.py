"""Solutions that do not use MDR, for comparison."""
