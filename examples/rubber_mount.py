"""
A vibrating rubber mount
========================

The round foot of a machine on rubber vibrates tangentially. Energy is dissipated by slip at its edge and by shear of the rubber
inside. The width of the loop depends on the frequency.
"""

import math

import numpy as np

import pymdr as mdr

rubber = mdr.Viscoelastic(mdr.StandardSolid(equilibrium="1 MPa", modulus="1 MPa", time="20 ms"), poisson=0.5)
foot = mdr.Paraboloid("50 mm")
depth, amplitude = 0.5e-3, 0.1e-3
rest = mdr.indent(depth, duration="0.1 s", steps=10) >> mdr.hold("0.5 s", steps=20)


def shaken(mu, frequency, cycles=3, rows=80):
    """The foot, pressed in and at rest, then shaken by a sine."""
    phase = 2 * np.pi * np.arange(1, cycles * rows + 1) / rows
    t = 0.6 + phase / (2 * np.pi * frequency)
    sine = mdr.Path(time=t, shift=amplitude * np.sin(phase))
    return mdr.solve(mdr.Contact(foot, rubber, friction=mdr.Coulomb(mu)), rest >> sine)


def last_cycle(result, name, rows=80):
    """What is lost in the last cycle."""
    dissipated = result[name].values
    return float(dissipated[-1] - dissipated[-1 - rows])


for frequency in (0.5, 5.0, 50.0):
    result = shaken(0.4, frequency)
    whole, slip = (1e6 * last_cycle(result, name) for name in ("dissipated_energy", "slip_work"))
    print(f"{frequency:4g} Hz: {whole:.1f} uJ per cycle, {slip:.1f} uJ of it in slip")
figure = shaken(0.4, 5.0).plot()
figure.savefig("rubber_mount.png")
print("figure saved as rubber_mount.png")

# %%
# Without slip the foot is a spring 2 a G* whose loss modulus is (8/3) G'', and a cycle dissipates pi 2 a G*'' u^2.
frequency = 5.0
stuck = shaken(math.inf, frequency)
loss = 8 / 3 * float(rubber.shear.loss(2 * np.pi * frequency))
expected = np.pi * 2 * float(stuck["contact_radius"][-1]) * loss * amplitude**2
print(f"without slip {1e6 * expected:.1f} uJ per cycle")
assert abs(last_cycle(stuck, "dissipated_energy") / expected - 1) < 2e-3
