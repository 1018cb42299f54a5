"""Which of these devices meets the requirement, by what margin, and what limits it."""
