"""Make a recording folder from videos and images: look, choose, synchronise, write."""
