"""Step 2 under twist: the springs of torsion with Coulomb friction, exact in space.

A spring at the distance x from the axis carries q(x) = x Q(x). It sticks with dQ = 8 G dphi and slips at |Q| = Q_max(x; d), the image
of the traction mu p. Between a few radii Q is a constant, plus or minus the limit of some indentation, minus a multiple of g: such
segments are the whole state, whatever the history.
"""
