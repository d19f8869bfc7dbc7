"""The PyBullet implementation of the simulator port; the only importer of pybullet."""
