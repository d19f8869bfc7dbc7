"""Random damage to real files: no crash, no hang, a code for each."""
