"""What a user could pick instead of the workbench, each run as one who knows it would."""

from studies.performance.peers import casadi_machine, jax_scan, numba_loop, python_control, scipy_lsoda
from studies.performance.peers.contract import Peer

PEERS = (
    Peer("python-control nlsys, defaults", "control", 8000.0, 1, python_control.runner),
    Peer("SciPy LSODA 1e-6, NumPy", "scipy", 1300.0, 2, scipy_lsoda.runner),
    Peer("CasADi VM mapaccum", "casadi", 110.0, 8, casadi_machine.runner),
    Peer("JAX vmap + scan, x64", "jax", 50.0, 64, jax_scan.runner),
    Peer("numba scalar loop", "numba", 14.0, 16, numba_loop.runner),
)

__all__ = ["PEERS", "Peer"]
