"""Packages around the C of a law: a controller of ROS 2 and a block of Simulink.

The functions `ros2.ros2` and `simulink.simulink` return the files of a package by their paths, with the C unchanged.
Their text stands in `handover/templates`, and was compiled and run against stubs of the other program's headers.
"""
