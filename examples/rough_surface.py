"""
A rough surface on a plane
==========================

A ground steel surface is pressed on glass. The line of springs gives the stiffness of the joint under a load, as a mean over
realisations with a band. The true area is not on the line and is refused.
"""

import numpy as np

import pymdr as mdr

surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="10 um", seed=1)
steel, glass = mdr.Elastic("210 GPa", 0.3), mdr.Elastic("70 GPa", 0.22)
pressed = mdr.press_rough(surface, steel, glass, normal_force=np.geomspace(0.01, 1e3, 26))
print(pressed)
figure = pressed.plot()
figure.savefig("rough_surface.png")
print("figure saved as rough_surface.png")

# %%
# At large loads it is a flat square punch, whose stiffness corresponds to the capacity of a plate:
full = pressed.data.attrs["full_contact_stiffness"]
modulus = mdr.effective_moduli(steel, glass).normal
assert abs(float(pressed["normal_stiffness"][-1]) / (1.15230 * modulus * 1e-3) - 1) < 1e-5

# %%
# At small loads the stiffness grows more slowly with the load than the power law with its published constant:
fraction = pressed["normal_stiffness"].values / full
some = (fraction > 0.05) & (fraction < 0.4)
force = pressed["normal_force"].values
exponent = np.polyfit(np.log(force[some]), np.log(fraction[some]), 1)[0]
print(f"k ~ F^{exponent:.2f}; the power law of many decades is F^{1 / 1.8:.2f}")
assert 0.4 < exponent < 1 / 1.8

# %%
# The contact area is refused:
try:
    pressed["contact_area"]
except mdr.NotValidError as refusal:
    print(refusal)
else:
    raise AssertionError("no area on this line")

# %%
# A ball with the same roughness is softer than a smooth one where Hertz' depth is below it:
ball = mdr.press_rough(surface, steel, glass, normal_force=np.geomspace(0.1, 100.0, 16), radius="10 mm")
figure = ball.plot()
figure.savefig("rough_surface_2.png")
print("figure saved as rough_surface_2.png")
softer = (ball["normal_stiffness"] / ball["hertz_stiffness"]).values
print(f"{softer[0]:.2f} and {softer[-1]:.2f} of Hertz at {0.1} N and {100.0} N")
assert softer[0] < 0.7
assert softer[-1] > 0.93
