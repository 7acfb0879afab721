"""
Modulus and adhesion of a gel over a map
========================================

A colloidal tip presses a gel that is stiffer in one place, at every pixel of a map. Modulus, work of adhesion, contact point and
baseline are fitted to each curve. The picture shows the stiff region and uniform adhesion.
"""

import numpy as np
import xarray as xr

import pymdr as mdr

rng = np.random.default_rng(3)
x = y = np.linspace(0, 30e-6, 12)
stiffer = np.exp(-((x - 18e-6) ** 2 + (y[:, None] - 12e-6) ** 2) / (7e-6) ** 2)
young = 2e3 + 500 * np.round(8 * stiffer)
motion = np.concatenate([np.linspace(-1e-6, 1.5e-6, 150), np.linspace(1.5e-6, -3e-6, 150)])

# %%
# The record of a cantilever of 0.05 N/m: the sample is tilted, and every force is noisy.
moduli, which = np.unique(young, return_inverse=True)
gels = [
    mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic(E, 0.5), adhesion=mdr.JKR("0.2 mJ/m^2")) for E in moduli
]
solved = mdr.solve_batch(gels, mdr.Path(travel=motion), machine_stiffness="0.05 N/m")
true = np.array([one["normal_force"].values for one in solved])[which.reshape(young.shape)]
force = true + 1e-10 * rng.normal(size=true.shape)
travel = motion + 1e-2 * (x + y[:, None])[..., None]

curves = xr.Dataset(
    {
        "force": (("y", "x", "sample"), 1e9 * force, {"units": "nN"}),
        "travel": (("y", "x", "sample"), 1e6 * travel, {"units": "um"}),
        "spring_constant": ((), 0.05, {"units": "N/m"}),
    },
    coords={"x": ("x", 1e6 * x, {"units": "um"}), "y": ("y", 1e6 * y, {"units": "um"})},
)

# %%
# One call fits all curves. With ``folder=`` an interrupted fit of a large map continues where it stopped.
start = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5), adhesion=mdr.JKR("1 mJ/m^2"))
fit = mdr.fit_map(start, curves, ["body.young", "adhesion.work"])
print(fit)
figure = fit.plot()
figure.savefig("map_of_a_gel.png")
print("figure saved as map_of_a_gel.png")

off = (fit["body.young"] - young) / fit["body.young_error"]
assert abs(float((off**2).mean()) - 1) < 4 * np.sqrt(2 / young.size)  # the errors are correct
