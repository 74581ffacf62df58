"""Which camera is awake, and where it looks (thesis sections 2.2.5 and 3.4)."""
