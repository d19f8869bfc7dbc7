"""The generators, one file each; `assetkit.generate.table` lists them."""
