"""The 3-D scene."""
