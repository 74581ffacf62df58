"""Cameras and the ground: lens and pose, homographies, the grid map, who sees what."""
