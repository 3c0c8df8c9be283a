"""The commands of ``stereotrack calibrate``, one file each."""
