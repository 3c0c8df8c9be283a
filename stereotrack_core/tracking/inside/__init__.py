"""What happens inside one frame: a tracker is watched while a copy of it does its step."""
