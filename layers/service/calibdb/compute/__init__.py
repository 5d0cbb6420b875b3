"""Documents in, documents out: what functions compute. No other package of the service imports the solver."""
