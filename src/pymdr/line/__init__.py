"""Step 2: solve on the line."""
