"""Axisymmetric trains and their disturbances as functions along a meridian: velocity and dynamics.

The flow is that of a single layer of forces on the membranes in a periodic round tube. It has four
parts, each in its files, all exact but for their rules of quadrature:

* the cell itself, in free space (`own_surface`);
* its nearest periodic images, in free space (`images`);
* all farther images, in closed form (`tail`);
* the tube's wall, wave by wave (`wall`), and the flow rate, which is held (`flow_rate`).

A disturbance of azimuthal number m that changes by exp(i q) from cell to cell keeps its form, so
every part is a matrix from the members of that number (`harmonics.azimuthal`) to the velocity R,
Phi, Z at the targets. `train` puts them together.
"""
