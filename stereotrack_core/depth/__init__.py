"""From images to a cloud: rectify, match, validate, background, points, outliers."""
