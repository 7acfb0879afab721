"""
Hysteresis of a gel
===================

A glass bead touches a gel that separates at a larger work than contact gains, at any speed. The edge of the contact rests between both works; what a loop
dissipates is known from its largest contact.
"""

import math

import pymdr as mdr

bead, gel = mdr.Paraboloid("50 um"), mdr.Elastic("30 kPa", 0.5)
gains, costs = 0.5e-3, 2e-3  # J/m^2
contact = mdr.Contact(bead, gel, adhesion=mdr.JKR(gains, work_receding=costs))

# %%
# Loops to three depths: after the turn the edge rests, and the force falls as under a flat punch.
for depth in ("1 um", "2 um", "4 um"):
    loop = mdr.solve(contact, mdr.indent(depth, steps=80) >> mdr.indent("-6 um", steps=300))
    assert loop.status is mdr.Status.PULLED_OFF
    a = loop["contact_radius"]
    turn = int(a.values.argmax())
    rests = int((abs(a[turn:] / a[turn] - 1) < 1e-12).sum())
    spent, whole = float(loop["adhesion_dissipation"][-1]), float(loop["dissipated_energy"][-1])
    print(
        f"{depth}: the edge rests in {rests} rows; {1e15 * spent:.1f} fJ by hysteresis, {1e15 * (whole - spent):.1f} fJ in jumps"
    )
    area = math.pi * float(a.max()) ** 2
    assert abs(spent / ((costs - gains) * area) - 1) < 1e-9
figure = loop.figures()["loop"]
figure.savefig("gel_hysteresis.png")
print("figure saved as gel_hysteresis.png")

# %%
# Advancing and receding contacts alone are JKR with one work each. The pull-off after a deep press is that of the larger.
pull = -mdr.pull_off(contact, machine_stiffness=0, pressed_to="4 um").normal_force
print(f"pull-off: {1e9 * pull:.1f} nN")
assert abs(pull / (1.5 * math.pi * costs * 50e-6) - 1) < 1e-9
