"""Tests of assetkit.retopo, with models whose colours and shapes are known in closed form."""
