"""Section 3 of Zhao 2019, number by number: what it prints, ours, and a verdict."""
