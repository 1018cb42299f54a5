"""Sensors on a turntable: from data sheet and schedule to a Problem."""
