"""Mass properties of solids: volume, centre of mass, inertia, principal axes and bounds on them."""
