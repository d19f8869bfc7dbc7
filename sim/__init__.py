"""The simulator port and its implementations. `bullet` is the only importer of pybullet."""
