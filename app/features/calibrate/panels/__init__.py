"""The page of the calibration: one part per step, and what stands around them."""
