"""Reproduction of Zhao 2019, section 3: every number and claim beside ours."""
