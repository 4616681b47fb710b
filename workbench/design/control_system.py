"""The type of a system of python-control, whose own package has none: the name under which others take and give one."""

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from control.lti import LTI

    System: TypeAlias = LTI
else:
    System = object  # whose attributes are checked where it comes in, as loading the package takes seconds
