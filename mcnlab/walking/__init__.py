"""From boxes to direction, heading and speed (thesis section 3.2)."""
