"""Models the finder is compared with: all effects at once, and a regression on the residual."""
