"""The generator: from a case's number to a measurement folder and its truth; imports nothing of `simgap` or `sim`."""
