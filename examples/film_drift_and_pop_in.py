"""
A film, drift and a pop-in
==========================

The springs of film and substrate give the modulus of a film on silicon from continuous stiffness. A hold gives the thermal drift of an indent. The load of
a pop-in gives its shear stress.
"""

import numpy as np

import pymdr as mdr

rng = np.random.default_rng(7)

# %%
# A film of 10 GPa and 500 nm on silicon, with 0.5 % of noise in the stiffness.
film, silicon, tip = mdr.Elastic("10 GPa", 0.3), mdr.Elastic("165 GPa", 0.22), mdr.AreaFunction([24.5])
body = mdr.Layered([mdr.Layer(film, "500 nm")], base=silicon)
contact = mdr.Contact(mdr.Paraboloid("20 um"), body, mdr.Elastic("1141 GPa", 0.07))
ball = mdr.solve(contact, mdr.load("1 mN", steps=300))
area, stiffness = np.pi * ball["contact_radius"].values ** 2, ball["normal_stiffness"].values
record = {
    "indentation": np.sqrt(area / 24.5) + 0.75 * 1e9 * area / stiffness,
    "normal_force": 1e9 * area,
    "harmonic_stiffness": stiffness * (1 + 0.005 * rng.normal(size=300)),
}
profile = mdr.continuous_stiffness(record, tip, poisson=0.3, points=8)
study = mdr.film_modulus(profile, "500 nm", silicon, thickness_error="5 nm")
print(study)
figure = study.plot()
figure.savefig("film_drift_and_pop_in.png")
print("figure saved as film_drift_and_pop_in.png")
assert study.interval[0] < 10e9 < study.interval[1]

# %%
# A drift of 0.1 nm/s.
part = np.concatenate(
    [np.linspace(0, 1, 100), np.linspace(1, 0.1, 90), np.full(200, 0.1), np.linspace(0.1, 0, 10)]
)
time = 0.25 * np.arange(400)
depth = 150e-9 + 50e-9 * part**0.7
depth[:100] = 200e-9 * np.sqrt(part[:100])
depth += 0.1e-9 * time + 0.1e-9 * rng.normal(size=400)
drift = mdr.thermal_drift(mdr.MeasuredCurve(force=1e-3 * part, indentation=depth, time=time))
print(drift)
figure = drift.plot()
figure.savefig("film_drift_and_pop_in_2.png")
print("figure saved as film_drift_and_pop_in_2.png")
assert float(drift["rate_low"][0]) < 0.1e-9 < float(drift["rate_high"][0])

# %%
# A pop-in at 0.4 mN under a round tip on fused silica.
round_tip = mdr.Contact(mdr.Sphere("1 um"), mdr.Elastic("72 GPa", 0.17), mdr.Elastic("1141 GPa", 0.07))
loading = mdr.solve(round_tip, mdr.load("1 mN", steps=400))
force, depth = loading["normal_force"].values, loading["indentation"].values
depth = depth + np.where(force > 0.4e-3, 8e-9, 0.0) + 0.05e-9 * rng.normal(size=400)
jump = mdr.first_pop_in(mdr.MeasuredCurve(force=force, indentation=depth), round_tip)
print(jump)
figure = jump.plot()
figure.savefig("film_drift_and_pop_in_3.png")
print("figure saved as film_drift_and_pop_in_3.png")
assert abs(float(jump["pop_in_force"][0]) / 0.4e-3 - 1) < 0.02
