"""Model extensions: accepted effects as data that packages and simulators can apply."""
