"""Pictures (PNG bytes) of scenes and of infeasible problems, projected onto the ground; equal for equal input."""
