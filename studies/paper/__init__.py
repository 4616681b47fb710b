"""The paper on AOSMC-RGS: its card of numbers, its printed arm, its laws, and tables that several studies share."""
