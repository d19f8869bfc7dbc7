"""Extended packages: what a sim-gap report measured goes into a package's physics, record and URDF."""
