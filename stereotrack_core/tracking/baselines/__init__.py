"""Other ways from measurements to a pose, to compare with; all else they share with the tracker."""
