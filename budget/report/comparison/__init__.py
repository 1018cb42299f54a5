"""A comparison of devices for people and programs: formats only, computes nothing."""
