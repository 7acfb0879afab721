"""Measured surfaces before step 1: their trends, gaps, resolution, spectrum, and the one bump that a body of revolution is."""
