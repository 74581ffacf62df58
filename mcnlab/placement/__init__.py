"""Where cameras go: cells, votes, coverage, exact choice (thesis chapter 2)."""
