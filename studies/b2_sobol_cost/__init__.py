"""The cost of Sobol indices here and in other packages."""
