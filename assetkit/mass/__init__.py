"""Mass, density and inertia of one object with bounds: from statements, materials, wall thickness or category."""
