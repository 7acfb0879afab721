"""
Dundurs' constant
=================

The constant called Dundurs' in the founding discussion paper lacks the factor 1/2 and has (1 - 2 nu) where (1 - nu)
belongs in the denominator. Both vanish together, so the test for elastic similarity is unaffected; the size is not:
for steel on aluminium -0.117 instead of -0.446.
"""

import pymdr as mdr

steel = mdr.Elastic("210 GPa", 0.30)
aluminium = mdr.Elastic("70 GPa", 0.33)
beta = mdr.effective_moduli(steel, aluminium).dundurs_beta

a, b = ((1 - 2 * m.poisson) / m.shear for m in (steel, aluminium))
printed = (a - b) / (a + b)
print(f"beta = {beta:.3f}, as printed {printed:.3f}")

assert abs(beta + 0.1167) < 1e-4
assert abs(printed + 0.446) < 1e-3
assert mdr.effective_moduli(steel, steel).similar
