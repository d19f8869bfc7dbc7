"""USD files (OpenUSD, `pxr`): `read` foreign stages, `write` packages and scenes, `reread` what was written."""
