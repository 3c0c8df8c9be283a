"""The articulated body: skeleton, proportions, cones, kinematics, sampling, visibility."""
