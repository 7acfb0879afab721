"""What knows no physics: curves on panels, roots, quadrature, exponential sums."""
