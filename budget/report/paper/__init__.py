"""Reproduction of the paper: terminal text, JSON, CSV and a document."""
