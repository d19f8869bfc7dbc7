"""The relations of the scene language, one file each: lowering, solver, plans, proofs, suggestions and page."""
