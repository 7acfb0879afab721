"""Step 3: from the line back to three dimensions."""
