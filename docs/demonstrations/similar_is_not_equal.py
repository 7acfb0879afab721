"""
Similar is not equal
====================

Argatov's discussion states elastic similarity correctly (its eq. 15), but it is often read as "equal materials". Equal bodies are
similar. An incompressible body is also similar to a rigid body and to any other incompressible body, and two bodies of different
Poisson's ratios are similar if their moduli are suitable. Two bodies of nearly equal stiffness may be far from similar. pymdr measures Dundurs' beta
and lowers its claims where it is not 0.
"""

import matplotlib.style
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
rubber = mdr.Elastic("3 MPa", 0.5)
nu = (0.3, 0.4)
shear = (1e9, 1e9 * (1 - 2 * nu[1]) / (1 - 2 * nu[0]))  # (1 - 2 nu) / G of both are equal
fitting = [mdr.Elastic(2 * G * (1 + n), n) for G, n in zip(shear, nu, strict=True)]

pairs = {
    "steel on steel": (steel, steel, True),
    "rubber on a rigid body": (rubber, mdr.Rigid(), True),
    "rubber on gel": (rubber, mdr.Elastic("30 kPa", 0.5), True),
    "2.6 GPa, ν = 0.3 on 1.4 GPa, ν = 0.4": (*fitting, True),
    "steel on a rigid body": (steel, mdr.Rigid(), False),
    "cork on rubber": (mdr.Elastic("3 MPa", 0.0), rubber, False),
}
betas = {}
path = mdr.load("0.1 N") >> mdr.drag("10 mN")
for name, (body, counterbody, similar) in pairs.items():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), body, counterbody, friction=mdr.Coulomb(0.3))
    beta = betas[name] = mdr.effective_moduli(body, counterbody).dundurs_beta
    level = mdr.solve(contact, path).claims["normal_force"].level
    print(f"{name:<40} beta = {beta:7.4f}   normal force: {level.value}")
    assert (abs(beta) < 1e-12) == similar
    assert level is (mdr.Level.EXACT if similar else mdr.Level.APPROXIMATE)

figure = Figure(figsize=(6.4, 2.8), layout="constrained")
axes = figure.subplots()
axes.barh(list(betas), list(betas.values()))
axes.axvline(0.01, color="k", ls=":", lw=1, label="limit of the assumption, 0.01")
axes.invert_yaxis()
axes.set_xlabel("Dundurs' beta")
axes.legend()
