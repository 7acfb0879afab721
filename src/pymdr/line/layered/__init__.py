"""The line of a layered body, whose springs interact: d0, F0, U0, k and k' as curves in the contact radius.

With lengths in thicknesses h of the top layer, a line load q in E* h per length obeys in a contact of radius a

    q(x) - (K q)(x) = d - g(x),   (K q)(x) = (1/pi) int_0^a [M(x - y) + M(x + y)] q(y) dy

(Lebedev and Ufliand 1958). It is q = (1 - K)^-1 (g(a) - g) + (d - g(a)) q_A, with the line load q_A of a flat punch. A contact
is smooth where q(a) = 0; F = 2 int q, U = int q (d - g), k = 2 int q_A and k' = 2 q_A(a)^2.
"""

from __future__ import annotations

from pymdr.line.layered.line import LayeredLine as LayeredLine
from pymdr.line.layered.line import lower_bound as lower_bound
from pymdr.line.layered.tables import Limit as Limit
