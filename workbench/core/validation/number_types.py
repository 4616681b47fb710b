"""The type of numbers as a caller has them, alone, in lists or in an array, before the vocabulary of refusals."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    Numbers: TypeAlias = ArrayLike
else:
    Numbers = object  # which a door lets pass: whoever takes it says by name what is wrong with it

Values: TypeAlias = Mapping[str, Numbers]  # by the names of what they are given for
