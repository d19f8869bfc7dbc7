"""The smallest input for every diagnostic code, one file per area."""
