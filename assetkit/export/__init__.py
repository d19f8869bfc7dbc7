"""Packages in the formats of others: MJCF, URDF and USDZ, with a finding for everything that a format cannot hold."""
