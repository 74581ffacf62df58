"""From video to boxes and traces: silhouettes, optical flow, feet (thesis sections 2.3, 3.1)."""
