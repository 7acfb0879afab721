"""Step 1: from three dimensions to the line."""
