"""Occlusion foreseen: the thesis's tables and equations, pairs, forecasters, scores."""
