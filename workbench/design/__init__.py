"""Design by linear models: the only room that opens python-control.

Its rooms know equations and matrices, and no robot, law or loop by name; every answer comes with a certificate of
`matrices.py`. Read `linear` first, then `riccati`; `riccati_flow` and `chattering` stand on these.
`frequency` has figures of linear systems: margins, norms, zeros and sampled answers. `loop_boxes` proves gains, decay
and damping of a loop over boxes of its parameters.
"""

from workbench.design.linear import linearize, to_control

__all__ = ["linearize", "to_control"]
