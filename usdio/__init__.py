"""The only importer of pxr: read stages, write packages, judge them."""
