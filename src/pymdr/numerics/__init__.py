"""Numerics without physics: curves on panels, graded tables, roots, quadrature, exponential sums."""
