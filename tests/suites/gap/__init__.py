"""Truth generators sealed from the library, and cases with hidden effects."""
