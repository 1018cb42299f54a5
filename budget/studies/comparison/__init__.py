"""Comparison of devices against a requirement: verdicts, margins, ranking."""
