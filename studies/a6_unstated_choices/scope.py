"""The scope of the findings of a6: the information that laws have, our own assumptions, and what was not varied."""

from studies.a6_unstated_choices.draws import LIMIT
from studies.a6_unstated_choices.loops import LONGEST, NAMES, SHORTEST, STIFF
from studies.paper.unstated_choices import assumptions, omitted_choices

INFORMATION = (
    "In a draw the six laws have the same horizon, square wave and model. The rivals have the same measurements, exact "
    "or by (10); AOSMC-RGS has separate ones. K(0) and gamma are the same for the laws that adapt."
)
# What no factor of this study varies. The torque limit is one of its variations instead.
OMITTED_CHOICES = tuple(choice for choice in omitted_choices(NAMES) if choice.name != "torque limit")
ASSUMPTIONS = (
    f"The ranges of the card, horizons from {SHORTEST} to {LONGEST} s, R from {STIFF:g} on, each reading as likely as "
    f"the others, and the two scales of the four priors. The limit of {LIMIT[0]:g} and {LIMIT[1]:g} N m. Not varied: "
    f"{assumptions(OMITTED_CHOICES)}."
)
REST = f"R below {STIFF:g} N m/(rad s); {'; '.join(choice.name for choice in OMITTED_CHOICES)}"
LIMITATIONS = f"other ranges; {REST}"
