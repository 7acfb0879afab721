"""Solutions that do not use MDR, to hold it against."""
