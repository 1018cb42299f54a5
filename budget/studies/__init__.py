"""Studies: questions of a user, answered by the methods on a Problem."""
