"""The verifier of augmented episodes: exact distances between moving and inserted bodies, settling, bit identity."""
