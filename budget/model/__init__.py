"""One model of a calibration: windows, weights, sources; no files, no statistics."""
