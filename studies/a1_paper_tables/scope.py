"""The scope of the findings of a1: the information of the law, and the choices that are varied and left out."""

from studies.paper.card import PROPOSED_LAW
from studies.paper.unstated_choices import assumptions, choices_of, omitted_choices

AS_PRINTED_INFORMATION = (
    "Positions; the model with (3) as printed, which is not the exact one; and, by (24), the true disturbance. Without "
    "observer (10), velocities too."
)
INFORMATION = (
    "Positions; the exact model where (3) is repaired, and elsewhere the model with (3) as printed; and, by (24), the "
    "true disturbance."
)
OURS = choices_of(PROPOSED_LAW, "FS")
# The choices that the runs of this page vary, in this finding or in another one.
VARIED_CHOICES = (
    "sign of (33)",
    "velocity in (28)",
    "D_hat of (24)",
    "C of (3)",
    "shape of (33)",
    "Q",
    "R",
    "horizon of FS",
)
ASSUMPTIONS = assumptions(omitted_choices(VARIED_CHOICES, OURS))
