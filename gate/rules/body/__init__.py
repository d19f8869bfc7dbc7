"""Gate rules on rigid bodies: mass, centre of mass, inertia, density, transforms, velocities."""
