"""Head and hands, detected elsewhere or in the data at hand, as measurements of the pose."""
