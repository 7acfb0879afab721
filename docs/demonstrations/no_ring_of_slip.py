"""
Not always a ring of slip
=========================

Argatov's discussion of the method presses first and pulls afterwards. Then a ring of slip begins at the edge, however small the
pull (Cattaneo 1938, Mindlin 1949). The cause is the order, not the loads. If both forces grow together in a ratio below the
coefficient of friction, nothing slips (Mindlin and Deresiewicz 1953): the ratio of traction and pressure is the same everywhere.
Both histories below end at the same forces.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))

first_pressed = mdr.solve(joint, mdr.load("50 N") >> mdr.drag("10 N"))
together = mdr.solve(joint, mdr.ramp(normal_force="50 N", tangential_force="10 N"))

a = float(together["contact_radius"][-1])
print(f"stick radius over contact radius: {float(first_pressed['stick_radius'][-1]) / a:.4f} and 1")
assert abs(float(first_pressed["stick_radius"][-1]) / a - (1 - 10 / 15) ** (1 / 3)) < 1e-12
assert abs(float(together["stick_radius"][-1]) / a - 1) < 1e-12
assert float(together["dissipated_energy"][-1]) == 0.0 < float(first_pressed["dissipated_energy"][-1])

# %%
# Without slip the shift follows the indentation, u = (E*/G*) (F_x / F_N) d, and the traction is 1/5 of the pressure everywhere.
moduli = mdr.effective_moduli(steel, steel)
ratio = moduli.normal / moduli.tangential * 10 / 50
assert np.isclose(together["shift"][-1], ratio * together["indentation"][-1], rtol=1e-12)
r = a * np.linspace(0.0, 0.999, 200)
tau, p = (together.field(name, r=r).values for name in ("shear_traction", "pressure"))
assert np.allclose(tau, p / 5, rtol=1e-10)

figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
axes.plot(r / a, 0.3 * p / 1e6, "k:", label="limit of friction")
axes.plot(r / a, first_pressed.field("shear_traction", r=r) / 1e6, label="pressed, then pulled")
axes.plot(r / a, tau / 1e6, label="both together")
axes.set_xlabel("r / a")
axes.set_ylabel("shear traction (MPa)")
axes.legend()
