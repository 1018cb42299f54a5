"""Zhao 2019, section 3, computed again: every number and claim beside ours."""
