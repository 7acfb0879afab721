"""
A random history of a million steps
===================================

Nothing is discretised in space, and the cost of a step does not depend on the length of the history. Only the requested rows are
stored; fields at any of them follow the path again.
"""

import time

import numpy as np

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
n = 1_000_000
random = np.random.default_rng(7)
depth = 2e-6 + 0.5e-6 * np.cumsum(random.standard_normal(n)) / np.sqrt(n)
shift = 0.4e-6 * np.sin(np.arange(n) * 0.05) + 0.2e-6 * random.standard_normal(n)

mdr.solve(joint, mdr.Path(indentation=depth[:10], shift=shift[:10]))  # loads the compiled kernels
start = time.perf_counter()
result = mdr.solve(joint, mdr.Path(indentation=depth, shift=shift), keep=1000)
print(f"{n} steps in {time.perf_counter() - start:.2f} s; {result.data.sizes['step']} rows kept")
print(result.summary())
figure = result.figures()["energies"]
figure.savefig("random_history.png")
print("figure saved as random_history.png")

# %%
# The traction of the last row adds up to its force:
a = float(result["contact_radius"][-1])
t, weight = np.polynomial.legendre.leggauss(2000)
r = a * np.sin(0.25 * np.pi * (t + 1))
tau = result.field("shear_traction", r=r).values
total = float(np.sum(weight * 0.25 * np.pi * a * np.cos(0.25 * np.pi * (t + 1)) * 2 * np.pi * r * tau))
assert abs(total - float(result["tangential_force"][-1])) < 1e-4 * 0.3 * float(result["normal_force"][-1])
