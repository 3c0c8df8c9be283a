"""ROS bags: images by topic, and the cameras that they state."""
