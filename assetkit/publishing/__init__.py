"""Release folders of packages: which licences let them go, attributions, and a manifest of hashes."""
