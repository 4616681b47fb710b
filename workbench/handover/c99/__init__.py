"""A sampled law as C99.

Read `c_code` first, then `c_source`, the pipeline: `c_variables` names what is read, `c_assignments` writes a graph as
lines, `c_advance` puts them under the equations of the stages. Operations and functions are `engine.machines`'.
"""
