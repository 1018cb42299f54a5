"""Reference budgets: what a budget was, whether it still is, and why it moved."""
