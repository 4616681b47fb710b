"""Equations of robots: time and size of the derivation beside other tools."""
