"""Tests of `assetkit.pose`: up axis, upright direction and front."""
