"""The package of one asset on disk: its record, its URDF twin, and how it is released."""
