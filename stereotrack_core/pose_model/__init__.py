"""2-D pose detection in single pictures: the pretrained detector, and models of the user.

- :mod:`.detector` finds people in a picture and their 33 landmarks (``load_detector``).
- :mod:`.crops` says which square part of a picture a network sees, and gives it usable contrast.
- :mod:`.installation` fetches, checks and finds the detector's files.
- :mod:`.onnx_model` runs a model of the user; :mod:`.detect` runs either over a recording.

Places are pixels of the raw picture: (0, 0) is the centre of the top left pixel.
"""
