"""Calibration of a device as an uncertainty-propagation problem; its simulation."""
