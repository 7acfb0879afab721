"""
A circular fretting test
========================

A steel ball is pressed with 50 N and moved along circles. Below the shift of first sliding its middle sticks; above it all slips, and
every turn dissipates the same energy.
"""

import math

import numpy as np

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
small = mdr.solve(ball, mdr.load("50 N") >> mdr.circle(shift="0.4 um", turns=2, steps=256))
print(small)
figure = small.plot()
figure.savefig("circular_fretting.png")
print("figure saved as circular_fretting.png")

# %%
# Slip in a steady turn of radius A: a spring with the limit m lags by the angle arccos(m / A), so that its force has the component
# sqrt(m^2 - m^4 / A^2) along the motion.

moduli = mdr.effective_moduli(steel, steel)
depth = float(small["indentation"][0])
slides = 0.3 * moduli.normal / moduli.tangential * depth
radius = 1.25 * slides
large = mdr.solve(ball, mdr.load("50 N") >> mdr.circle(shift=radius, turns=4, steps=1024))
work = large["dissipated_energy"].values
per_turn = work[-1] - work[-257]

x, weights = np.polynomial.legendre.leggauss(40)
limit = depth * (1 - (0.5 * (x + 1)) ** 2)
along = limit * np.sqrt(1 - (limit / (1.25 * depth)) ** 2)
force = 2 * 0.3 * moduli.normal * math.sqrt(10e-3 * depth) * float(0.5 * weights @ along)
print(f"{per_turn:.4g} J a turn, steady solution {2 * math.pi * radius * force:.4g} J")
assert abs(per_turn / (2 * math.pi * radius * force) - 1) < 5e-4

# %%
# The force lags behind the shift.

figure = large.plot()
figure.savefig("circular_fretting_2.png")
print("figure saved as circular_fretting_2.png")
