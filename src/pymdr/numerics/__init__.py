"""Numerics without physics: curves on panels, roots, quadrature, exponential sums."""
