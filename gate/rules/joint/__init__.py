"""Gate rules on joints and articulations: frames, axes, limits, drives, motion ranges, overlap of links."""
