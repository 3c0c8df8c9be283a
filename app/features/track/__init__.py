"""Track: runs of the tracker."""
