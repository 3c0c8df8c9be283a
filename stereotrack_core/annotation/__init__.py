"""Landmarks that people click: what they are, how they agree, what they tell about the pose."""
