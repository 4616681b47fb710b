"""The C of a law wrapped for other houses: an S-function of Simulink, a controller of ROS 2."""
