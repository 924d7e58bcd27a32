"""Fitting what perception decides by, to frames and rendered rooms that it may be chosen by."""
