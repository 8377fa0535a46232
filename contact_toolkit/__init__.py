"""Distance queries and contact forces between arbitrarily shaped bodies; needs no simulator."""
