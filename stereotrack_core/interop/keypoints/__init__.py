"""Predicted keypoints in the files of 2-D detectors; one module for each format."""
