"""
A factor of two in the loop
===========================

The dissipation of a sphere that vibrates at constant load (Mindlin and Deresiewicz 1953) is written with the compliance (2 - nu)
/ G. Two bodies have two compliances, and their sum is 4 / G*. With the compliance of one body, as for a sphere on a rigid plane, the
calculated dissipation of two equal spheres, over the relative shift of their centres, is one half of the true value.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
mu, force = 0.3, 50.0
pull = 15.0 * np.linspace(0.05, 0.95, 19)  # amplitudes of the tangential force in N


def formula(compliance, radius):
    """Loss of one cycle for the compliance (2 - nu) / G, in J."""
    q = pull / (mu * force)
    left = (1 - q) ** (1 / 3)
    return 9 * (mu * force) ** 2 / (10 * radius) * compliance * (1 - left**5 - 5 * q / 6 * (1 + left**2))


def followed(contact):
    """Loss of the second cycle of the amplitudes, and the contact radius."""
    losses = []
    for q in pull:
        result = mdr.solve(
            contact, mdr.load(force) >> mdr.cycle(tangential_force=float(q), cycles=2, steps=8)
        )
        losses.append(float(result["dissipated_energy"][-1] - result["dissipated_energy"][4]))
    return np.array(losses), float(result["contact_radius"][-1])


one = (2 - steel.poisson) / steel.shear
spheres = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(mu))
losses, a = followed(spheres)
assert np.allclose(losses, formula(2 * one, a), rtol=1e-9)
assert np.allclose(2 * formula(one, a), losses, rtol=1e-9)
moduli = mdr.effective_moduli(steel, steel)
assert abs(moduli.tangential * 2 * one / 4 - 1) < 1e-14

# %%
# For a sphere on a rigid plane one compliance is right; its shift is that of the sphere.
plane = mdr.Contact(mdr.Paraboloid("10 mm"), steel, friction=mdr.Coulomb(mu))
alone, a_plane = followed(plane)
assert np.allclose(alone, formula(one, a_plane), rtol=1e-9)

figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
axes.loglog(pull, losses, "ko", label="two spheres, followed")
axes.loglog(pull, formula(2 * one, a), "C0", label="both compliances")
axes.loglog(pull, formula(one, a), "C3--", label="one compliance")
axes.set_xlabel("amplitude of the tangential force (N)")
axes.set_ylabel("loss of one cycle (J)")
axes.legend()
