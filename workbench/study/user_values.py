"""The values of a study's author: what goes into a work, comes out of it, or stands in a paper has a type of theirs."""

from typing import Any, TypeAlias

UserValue: TypeAlias = Any  # the author knows the type, and the workbench hands the value on
