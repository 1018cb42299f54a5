"""The allocation for people and programs: formats only, computes nothing."""
