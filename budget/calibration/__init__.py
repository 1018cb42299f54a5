"""From devices and a procedure to the calibration's Problem, and its referee."""
