"""What comes in: recordings, scenes, videos, and the readers of each dataset."""
