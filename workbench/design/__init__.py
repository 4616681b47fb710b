"""Analysis and design by linear models, each answer with its certificate.

`linear` linearises equations and finds their rest points; `frequency` computes margins, norms and zeros; `riccati`
and `riccati_flow` compute gains; `linear_loop` gives poles, margins and responses of a closed loop; `loop_boxes` proves
bounds of them over boxes of parameters; `chattering` predicts the oscillations of switching laws; `reduction` lowers
orders, and `structured_uncertainty` bounds structured singular values. This package knows equations and matrices, and
it alone imports python-control. Read `linear` first, then `riccati`.
"""

from workbench.design.linear import linearize, to_control

__all__ = ["linearize", "to_control"]
