"""What the errors of a calibrated unit do to inertial navigation."""
