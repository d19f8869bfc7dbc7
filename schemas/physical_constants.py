"""Physical constants that several packages share."""

GRAVITY_MPS2 = 9.81
"""Magnitude of gravity where nothing else is stated: the default of physics engines. Standard gravity is 9.80665
(3rd CGPM 1901); on Earth it is between 9.78 and 9.83."""
