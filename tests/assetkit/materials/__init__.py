"""Tests of `assetkit.taxonomy.material_classes`."""
