"""The inner parts of the workbench that this bench times, each by itself.

No engineer needs them, and the other files of the bench have them from here. The kernel is timed from its operations
(`KernelPlan`, `lower`) to machine code (`llvm`) and to a call of it (`native`, `Job`).
The choice of a step (`search_step`, `pilot_runs`, `METHODS`) is held against the precision of peers. The page that a
reader turns is timed from its data (`live_data`, `loop_study`) to its text (`html`).
"""

from workbench.core.methods import METHODS
from workbench.engine import Trajectories
from workbench.engine.job import Job
from workbench.engine.kernel import llvm, native
from workbench.engine.kernel.lowering import lower
from workbench.engine.kernel.plan import KernelPlan
from workbench.engine.pilot_selection import pilot_runs
from workbench.engine.step_choice import Pilots, StepChoice, search_step
from workbench.report.html_page import html
from workbench.report.live.live_data import live_data
from workbench.report.live.loop_study import loop_study

__all__ = [
    "METHODS",
    "StepChoice",
    "Job",
    "Pilots",
    "KernelPlan",
    "Trajectories",
    "html",
    "live_data",
    "llvm",
    "loop_study",
    "lower",
    "native",
    "pilot_runs",
    "search_step",
]
