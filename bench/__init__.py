"""Timings against peers; beside the package, not in it."""
