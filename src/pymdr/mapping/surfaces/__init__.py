"""Measured surfaces before step 1: trends, gaps, resolution, spectrum, and the mean profile of a bump."""
