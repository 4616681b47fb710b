"""Laws in a computer: sampling periods, delays, noise, and the limits at which loops are lost."""
