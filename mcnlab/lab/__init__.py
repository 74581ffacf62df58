"""The laboratory: re-running the notebooks, the report, and measuring what is bundled."""
