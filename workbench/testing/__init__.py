"""The tests that a block of a user's own must pass: a class of tests for each kind of block, to subclass.

This package may use every other package, and no other uses it. It needs no pytest: a class of tests is a plain class
whose methods are named `test_...`, which pytest collects from a subclass named `Test...`. Read `law_tests.py` first,
then `block_tests.py`, which has the tests that plants, observers and laws share.

Examples
--------
>>> class TestMotor(wb.testing.PlantTests):
...     def plant(self):
...         return wb.DCMotor()
>>> TestMotor().test_each_jacobian_is_exact()
"""

from workbench.testing.law_tests import LawTests
from workbench.testing.metric_tests import MetricTests
from workbench.testing.observer_tests import ObserverTests
from workbench.testing.plant_tests import PlantTests
from workbench.testing.target_tests import TargetTests

__all__ = ["LawTests", "MetricTests", "ObserverTests", "PlantTests", "TargetTests"]
