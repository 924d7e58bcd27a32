"""Weights of the model in occlusion.py; written by `train_rejoin`, not by hand."""

BIAS = 14.34
MISFIT = -5.09
BREADTH = -2.27
TOP = -6.69
OPEN_WAY = -9.02
CHROMA = -3.69
