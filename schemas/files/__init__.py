"""Files as data: dataclasses of arrays in one archive, references between files, damaged archives."""
