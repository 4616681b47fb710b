"""Each public plant, and each element before or behind one, passes the tests of a plant of a user's own."""

import pytest

import workbench as wb
from tests.support.cases import heavy_but
from tests.support.house_blocks import LONG_TESTS, example_of, public_classes, without
from workbench.blocks.loop import AbstractPlant
from workbench.blocks.plants import AbstractElement
from workbench.core import layout
from workbench.testing import PlantTests

ROOM = ("workbench.blocks.plants",)
PLANTS = {**public_classes(ROOM, AbstractPlant), "arms.Manipulator": wb.Manipulator}
ELEMENTS = public_classes(ROOM, AbstractElement)


def motor_with(element):
    """A motor behind or before an element."""
    motor = wb.DCMotor.position()
    return wb.EquippedPlant(motor, **{"actuators" if element.signal in motor.inputs else "sensors": (element,)})


def spring():
    """A plant of functions, whose numbers have units; those of the docstring's example have none."""
    numbers = layout(k=("N/m", 40.0), m=("kg", 2.0))
    return wb.OdePlant.of(
        lambda t, x, u, p: [x[1], (u[0] - p.k * x[0]) / p.m], ("x:m", "v:m/s"), ("F:N",), p=numbers, x0=[0.1, 0.0]
    )


MAKERS = {name: lambda cls=cls: example_of(cls) for name, cls in PLANTS.items()}
MAKERS |= {f"a motor with {name}": lambda cls=cls: motor_with(example_of(cls)) for name, cls in ELEMENTS.items()}
MAKERS[next(name for name, cls in PLANTS.items() if cls is wb.OdePlant)] = spring


LIGHT = "blocks.CartPole"
EQUATIONS_LIGHT = *PLANTS, "a motor with blocks.Backlash"  # other elements have fewer equations


@pytest.fixture(scope="class", params=heavy_but(MAKERS, *EQUATIONS_LIGHT))
def any_plant(request):
    request.cls.example = MAKERS[request.param]()


@pytest.mark.usefixtures("any_plant")
@without(*LONG_TESTS)
class TestEquations(PlantTests):
    def plant(self):
        return self.example


@pytest.fixture(scope="class", params=heavy_but(MAKERS, LIGHT))
def light_plant(request):
    request.cls.example = MAKERS[request.param]()


@pytest.mark.usefixtures("light_plant")
@without(*sorted(name for name in dir(TestEquations) if name.startswith("test_") and name not in LONG_TESTS))
class TestRuns(PlantTests):
    def plant(self):
        return self.example

    @pytest.mark.heavy
    def test_its_live_page_computes_the_same_numbers(self):
        PlantTests.test_its_live_page_computes_the_same_numbers(self)


@without(*sorted(name for name in dir(PlantTests) if name.startswith("test_") and "energy" not in name))
class TestTwoMasses(PlantTests):
    """Two masses with a spring, which waste no energy."""

    lossless = True

    def plant(self):
        return wb.TwoMasses(x_1=0.1)

    def stored_energy(self, plant, x):
        spring = plant.k * (x.x_1 - x.x_2) ** 2
        return (plant.m_1 * x.x_1d**2 + plant.m_2 * x.x_2d**2 + spring) / 2
