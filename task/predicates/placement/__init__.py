"""Where objects are in relation to others: in, on, near, beside, stacked, hung, covered."""
