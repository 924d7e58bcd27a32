"""Weights of the model in occlusion.py; written by `train_rejoin`, not by hand."""

BIAS = 16.56
MISFIT = -6.28
BREADTH = -1.68
TOP = -7.49
OPEN_WAY = -9.80
CHROMA = -4.36
