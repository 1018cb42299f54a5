"""Methods on a Problem: law of propagation, Monte Carlo, Sobol' indices, allocation."""
