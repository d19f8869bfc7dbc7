"""Mass, centre of mass and inertia of solids (kg, m, kg m2), principal axes, bounds on them; read `inertia` first."""
