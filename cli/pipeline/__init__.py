"""`mana pipeline`: pipelines checked, explained and lowered to orders, before any simulator starts."""
