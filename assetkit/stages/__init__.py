"""The seven stages, one file each; their order is in `assetkit.pipeline`."""
