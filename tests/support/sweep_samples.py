"""A sample of a sweep in a ledger."""

from tests.support.arms import arm_instruments
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.executors import on_threads
from workbench.study.ledger.store import complete, open_ledger
from workbench.study.sweep_runs import tasks_of


def sample(out, given, **options):
    """What the sweep gives, through a ledger."""
    one = compile_sweep(given)
    tasks = tasks_of([one])
    with open_ledger(out) as ledger:
        complete(tasks, ledger, lambda missing: on_threads([one], missing, **options))
        return one.sample(ledger.read(task.name) for task in tasks)


class Digital:
    """An arm under a law that a computer runs behind noisy instruments."""

    def ode(self, name="loop"):
        arm = paper_arm()
        law = SlidingMode(model=arm, Lambda=[6.0, 6.0], K=[40.0, 20.0], phi=0.1)
        loop = ClosedLoop(
            Manipulator(arm, q=[0.5, 0.0]), ArmFullState(2), law, Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
        )
        return loop.digital(2e-3, arm_instruments(2, noise_q=1e-4), name=name)
