"""Results as text, pictures and pages: formats only, computes nothing."""
