"""Shape features of a solid: cavities, openings, support surfaces, resting planes, protrusions, symmetry."""
