"""
From a deflection in volts to the modulus
=========================================

A laboratory exports the signal of the photodiode in V and the height of the cantilever, with a preamble, decimal commas and semicolons. Sensitivity and
spring constant make it a force curve; the modulus of the gel is 5 kPa.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import pymdr as mdr

SPRING, SENSITIVITY = 0.05, 50e-9  # N/m, m/V
rng = np.random.default_rng(1)

# the record: approach and retreat of a bead of 5 um
depth = np.linspace(-1.5e-6, 0.4e-6, 800)
force = 4 / 3 * 5e3 / 0.75 * np.sqrt(5e-6) * np.clip(depth, 0, None) ** 1.5
travel = depth + force / SPRING
volts = np.concatenate([force, force[::-1]]) / SPRING / SENSITIVITY + 2e-3 * rng.normal(size=1600)
height = 9e-6 - np.concatenate([travel, travel[::-1]])

with TemporaryDirectory() as folder:
    file = Path(folder) / "gel.txt"
    rows = [f"{v:.6f};{h * 1e6:.6f}".replace(".", ",") for v, h in zip(volts, height, strict=True)]
    file.write_text("\n".join(["Microscope 7", "Operator: M", "", "deflection [V];height [um]", *rows]))
    approach, retreat = mdr.read_curves(file, sensitivity="50 nm/V", spring_constant="0.05 N/m")
    [prepared] = mdr.read_prepared_curves(
        file, segment="approach", sensitivity="50 nm/V", spring_constant="0.05 N/m"
    )

print(approach.segment, retreat.segment, approach.metadata["position"])
for step in prepared.steps:
    print(step)

# %%
# The signs of the table are known after reading; baseline and contact point are fitted with the modulus.
case = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("1 kPa", 0.5))
result = mdr.fit(case, prepared, ["body.young"])
print(result)
figure = result.plot()
figure.savefig("deflection_in_volts.png")
print("figure saved as deflection_in_volts.png")

assert abs(result["body.young"].value / 5e3 - 1) < 0.005
