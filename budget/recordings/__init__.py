"""Recordings of sensors: read, looked over, and turned into figures of noise."""
