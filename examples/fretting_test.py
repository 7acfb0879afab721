"""
A measured fretting test
========================

The amplitude of a test grows from cycle to cycle. The log shows the cycle at which gross slip begins, and its coefficient of friction. The model makes
the record, with the compliance of a machine added.
"""

import numpy as np

import pymdr as mdr

steel = mdr.Elastic("210 GPa", 0.3)
ball = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.5))
path = mdr.load("50 N")
for amplitude in np.linspace(0.2e-6, 3e-6, 20):
    path = path >> mdr.cycle(shift=amplitude, steps=100)
made = mdr.solve(ball, path).data[["shift", "tangential_force", "normal_force"]]
record = made.assign(shift=made["shift"] + made["tangential_force"] / 50e6)

# %%
# The machine is taken off, and every cycle compared with the loop of the model.

log = mdr.fretting_log(record, contact=ball, machine_stiffness="50 MN/m", worn_volume="0.001 mm^3")
print(log)
figure = log.plot()
figure.savefig("fretting_test.png")
print("figure saved as fretting_test.png")
assert abs(float(log["friction_coefficient"][-1]) - 0.5) < 1e-9

# %%
# The cycles on the map of running conditions.

figure = mdr.running_conditions(ball, np.linspace(1.0, 100.0, 50), record=log).plot()
figure.savefig("fretting_test_2.png")
print("figure saved as fretting_test_2.png")
