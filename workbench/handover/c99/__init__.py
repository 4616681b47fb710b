"""A sampled law as C99.

Read `c_code` first; `c_source` writes the stages of the loop, `c_body` their expressions, `c_functions` what they call.
"""
