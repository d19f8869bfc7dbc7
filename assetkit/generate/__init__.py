"""Parametric mechanisms and props: small programs that write source files with exact truth, for the same pipeline."""
