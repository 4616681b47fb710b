"""Plants behind an element."""

from workbench.blocks.loop import AbstractController, AbstractPlant, ClosedLoop
from workbench.blocks.plants import EquippedPlant
from workbench.core import block, initial, layout, rk4
from workbench.engine import simulate


@block
class Integrator(AbstractPlant):
    """x' = v."""

    x: float = initial(0.0, unit="V s")
    inputs = layout(v="V")
    outputs = layout(x="V s")

    def rate(self, t, x, u):
        return {"x": u.v}


def behind(elements, v, until, h=1e-3):
    """The times, and what leaves elements into which v(t) comes."""

    @block
    class Given(AbstractController):
        reads = layout()
        drives = layout(v="V")

        def command(self, t, z, est, ref):
            return {"v": v(t)}

    loop = ClosedLoop(EquippedPlant(Integrator(), elements), controller=Given())
    run = simulate(rk4(loop.ode(), h), until=until)
    return run.t, run["v_applied"][0].ravel()
