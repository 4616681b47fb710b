"""How fast the engine is: workload W beside what else could run it, measured on the user's own machine."""
