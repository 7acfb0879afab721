"""
Indentation modulus of zinc
===========================

A zinc crystal is much softer along its axis than across it. A cone pressed along the axis measures the indentation modulus, which depends on
all five constants. No mean of Young's moduli gives this modulus.
"""

import numpy as np

import pymdr as mdr

zinc = mdr.TransverselyIsotropic(c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa")
cone = mdr.Contact(mdr.Cone(half_angle="70.3 deg"), zinc)

result = mdr.solve(cone, mdr.load("10 mN", steps=50) >> mdr.load("0 N", steps=50))
print(result.summary())
figure = result.plot()
figure.savefig("zinc_indentation.png")
print("figure saved as zinc_indentation.png")

# %%
# Stiffness and contact radius at the largest load give the modulus, S = 2 E* a, for any tip:
modulus = float(result["normal_stiffness"][49] / (2.0 * result["contact_radius"][49]))
print(f"indentation modulus {modulus / 1e9:.2f} GPa")
assert abs(modulus / 67.799650579961365e9 - 1) < 1e-12

# %%
# Five constants of an isotropic body give its modulus:
young, poisson = 100e9, 0.25
same = mdr.TransverselyIsotropic(
    young_plane=young,
    young_axis=young,
    poisson_plane=poisson,
    poisson_axis=poisson,
    shear_axis=young / (2.0 * (1.0 + poisson)),
)
isotropic = mdr.effective_moduli(mdr.Elastic(young, poisson)).normal
assert np.isclose(mdr.effective_moduli(same).normal, isotropic, rtol=1e-12)
