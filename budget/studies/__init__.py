"""Questions a user asks, answered with the methods."""
