"""
Samples of a gel
================

Two gels have three samples each, with five curves per sample. Curves of one sample are not independent, so each sample counts once in the interval over
samples.
"""

import numpy as np

import pymdr as mdr

rng = np.random.default_rng(5)
tip = mdr.Paraboloid("5 um")
depth = np.linspace(-1e-6, 1e-6, 150)
curves, groups = {}, {}
for sample in range(1, 7):
    young = 2e3 * np.exp(0.2 * rng.normal())
    for place in range(5):
        local = young * np.exp(0.05 * rng.normal())
        force = 16 / 9 * local * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5 + 2e-11 * rng.normal(size=150)
        name = f"sample {sample}, place {place}"
        curves[name] = mdr.MeasuredCurve(force=force, travel=depth + force / 0.05, spring_constant="0.05 N/m")
        groups[name] = f"sample {sample}"

# %%
# Every curve by itself; the spring constant is known to 5 %.
start = mdr.Contact(tip, mdr.Elastic("10 kPa", 0.5))
study = mdr.fit_each(start, curves, ["body.young"], groups=groups, uncertainty={"spring_constant": "5 %"})
print(study)
figure = study.plot()
figure.savefig("samples_of_a_gel.png")
print("figure saved as samples_of_a_gel.png")

over_samples = study.statistics["body.young"]
assert float(over_samples["typical_low"]) < 2e3 < float(over_samples["typical_high"])
