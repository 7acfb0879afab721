"""
A rough surface pressed once
============================

Boundary elements press a surface of 80 x 80 heights in seconds. Its force curve is sufficient for friction, creep and contact
resistance, which then take milliseconds.
"""

import time

import numpy as np

import pymdr as mdr

surface = mdr.RoughSurface(hurst=0.8, rms="0.5 um", size="200 um", shortest="20 um", seed=4)
steel = mdr.Elastic("210 GPa", 0.3)
depths = np.linspace(0.15, 1.0, 14) ** 2 * 1.2e-6
pressed = mdr.press(surface, steel, steel, indentation=depths)
print(pressed)
figure = pressed.plot()
figure.savefig("pressed_surface.png")
print("figure saved as pressed_surface.png")

# %%
# The contact area at this resolution:
nominal = (200e-6) ** 2
print(f"{100 * float(pressed['contact_area'][-1]) / nominal:.1f} % of the patch touches")

# %%
# Fretting of the same joint, by the line with the force curve of the surface:
joint = mdr.Contact(pressed.force_curve(), steel, steel, friction=mdr.Coulomb(0.3))
depth = float(pressed["indentation"][9])
path = mdr.indent(depth) >> mdr.cycle(shift=depth / 10, cycles=2, steps=400)
mdr.solve(joint, path)  # compiles at the first use
started = time.perf_counter()
fretting = mdr.solve(joint, path)
print(f"two cycles in {1e3 * (time.perf_counter() - started):.0f} ms")
print(fretting.summary())
loop = fretting.plot()

# %%
# Its initial stiffness is that of full stick, G*/E* of the normal stiffness, which boundary elements give by one more solution:
moduli = mdr.effective_moduli(steel, steel)
stuck = moduli.tangential / moduli.normal * float(pressed["normal_stiffness"][9])
first = fretting["tangential_force"].values[1] / fretting["shift"].values[1]
print(f"tangential stiffness {first:.4g} N/m, by boundary elements {stuck:.4g} N/m")
assert abs(first / stuck - 1) < 0.02

# %%
# Rubber with the same surface creeps under a load:
rubber = mdr.Viscoelastic(mdr.StandardSolid(equilibrium="1 MPa", modulus="3 MPa", time="50 ms"), poisson=0.5)
scale = mdr.effective_moduli(mdr.Elastic("3 MPa", 0.5)).normal / moduli.normal
creep = mdr.solve(
    mdr.Contact(pressed.force_curve(), rubber),
    mdr.load(scale * float(pressed["normal_force"][9]), steps=10, duration="10 ms")
    >> mdr.hold("0.3 s", steps=60),
)
print(
    f"creep from {creep.to('indentation', 'um').values[9]:.2f} to {creep.to('indentation', 'um').values[-1]:.2f} um"
)

# %%
# The resistance of the joint, rho E*/k between bodies of equal resistivity (Barber 2003):
conductor = mdr.Elastic("210 GPa", 0.3, resistivity="140 nohm m")
loads = pressed["normal_force"].values
electric = mdr.solve(
    mdr.Contact(pressed.force_curve(), conductor, conductor), mdr.Path(normal_force=loads[4:-1])
)
resistance = electric["electrical_resistance"].values
by_elements = 140e-9 * moduli.normal / pressed["normal_stiffness"].values[4:-1]
print(
    f"{1e3 * resistance[0]:.2f} to {1e3 * resistance[-1]:.2f} mohm, by boundary elements {1e3 * by_elements[0]:.2f} to {1e3 * by_elements[-1]:.2f}"
)
assert np.allclose(resistance, by_elements, rtol=0.08)
