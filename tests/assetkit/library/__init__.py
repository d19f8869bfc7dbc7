"""Tests of `assetkit.library`: search, validation and previews."""
