"""Axisymmetric contact by boundary elements on concentric rings: no Abel map, no g(x), no springs.

The surface displacement of the elastic half-space is u = (1/(π E*)) ∬ p/R dS. With a pressure that is
constant on each ring it is a sum of closed forms with elliptic integrals; other bodies define their own. The contact solves Signorini's conditions p >= 0, u >= d - f, p (u - (d - f)) = 0: one disk, rings, or several of them.
Rings are graded as Chebyshev points to the edges of each contact zone and the condition is imposed at
the points in between: the force converges with the third power of the ring width, the pressure with
the second. Inside the solver lengths are divided by the largest radius, pressures by E*.
"""

from pymdr.independent.rings.meshes import RingMesh as RingMesh
from pymdr.independent.rings.meshes import RingProblem as RingProblem
from pymdr.independent.rings.meshes import RingState as RingState
from pymdr.independent.rings.meshes import edge_fit as edge_fit
from pymdr.independent.rings.settling import active_set as active_set
from pymdr.independent.rings.settling import bulge_radius as bulge_radius
from pymdr.independent.rings.settling import leading_inverses as leading_inverses
from pymdr.independent.rings.settling import product as product
from pymdr.independent.rings.solution import RingSolution as RingSolution
from pymdr.independent.rings.solution import displacement_at as displacement_at
from pymdr.independent.rings.solution import pressure_at as pressure_at
from pymdr.independent.rings.solving import Rings as Rings
from pymdr.independent.rings.solving import solve_adhesion as solve_adhesion
from pymdr.independent.rings.solving import solve_disk as solve_disk
from pymdr.independent.rings.solving import solve_force as solve_force
from pymdr.independent.rings.solving import solve_indentation as solve_indentation
from pymdr.independent.rings.surfaces import HALF_SPACE as HALF_SPACE
from pymdr.independent.rings.surfaces import Array as Array
from pymdr.independent.rings.surfaces import HalfSpace as HalfSpace
from pymdr.independent.rings.surfaces import Surface as Surface
from pymdr.independent.rings.surfaces import Zones as Zones
from pymdr.independent.rings.surfaces import ring_displacement as ring_displacement
