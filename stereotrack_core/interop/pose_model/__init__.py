"""Pose models as ONNX files: from a picture of a person to keypoints."""
