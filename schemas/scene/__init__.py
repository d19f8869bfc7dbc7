"""Scene programs, compiled scenes, sampling plans and samples as data."""
