"""Tests of `assetkit.package`: the URDF twin beside the USD package."""
