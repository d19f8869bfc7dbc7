"""Gate rules on the whole asset: metadata, units, files, extent, labels, record."""
