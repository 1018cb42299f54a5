"""What the methods do with a Problem: propagate, sample, decompose."""
