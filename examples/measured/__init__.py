"""One converter per public recording: `python -m examples.measured.<name> SOURCE_FOLDER OUT_FOLDER`.

None of the recordings is part of this repository. A source folder holds the arrays of one of them as NumPy files; each
converter says where the public original is, under which licence, which arrays it expects and what it assumes.
"""
