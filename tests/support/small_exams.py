"""A small exam of ordinary differential equations, and its grader."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
PROBLEMS = """
import math
import numpy as np
from math import exp

class Plain:
    sin, cos, largest = math.sin, math.cos, max
    num = staticmethod(float)

step = lambda x: int(x > 0) - int(x < 0)

def spring(m):
    return lambda t, x: [x[1], -4 * m.sin(x[0]) / m.cos(0.0) - exp(-t)]

def decay(m):
    rate = m.cos
    return lambda t, x: [-x[0] * rate(0.0) * m.num('1')]

def ramp(m):
    return lambda t, x: [m.largest(x[0], 0.5)]

def drag(t, x):
    return [-step(x[0]) * min(abs(x[0]), 1.0) + max([0.0, math.tanh(t)])]

def rows(t, x):
    A = np.array([[0.0, 1.0], [-math.exp(-t), x[1] * x[1]]])
    return A @ np.array([x[0], np.sign(x[1])]) + np.sin(x)

def stuck(t, x):
    while x[0] > 0.5:
        x = x / 2
    return [-x[0]]

def relay(t, x):
    if x[0] > 0:
        u = -1.0
    elif x[0] < 0:
        u = 1.0
    else:
        u = 0.0
    return [u + 0.3 * t]

def pushed(t, x):
    return [(-1.0 if x[0] > 0 else 1.0) + 0.3 * t]

def saturated(t, x):
    def sat(z):
        if z > 1: return 1.0
        if z < -1: return -1.0
        return z
    return [-sat(x[0] / 0.4) - float(np.sign(x[0])) + np.where(t > 1, 1.0, 2.0)]

def guarded(t, x):
    return [-x[0] / abs(x[0]) if x[0] != 0 else 0.5, 1.0 if x[1] == 0 else x[0]]

def filled(t, x):
    rate = np.zeros(2)
    rate[0] = x[1]
    rate[1] = -np.square(x[0])
    A = np.array([[0.0, 1.0], [-1.0, 0.0]])
    A[1, 1] = np.cos(x[0])
    return rate + A @ x

def solved(t, x):
    M = np.array([[3 + 2 * np.cos(x[1]), 1 + np.cos(x[1])], [1 + np.cos(x[1]), 1.0]])
    right = np.array([-np.sin(x[0]), -t])
    K = np.linalg.inv(np.array([[2.0, 1.0], [0.0, 4.0]]))
    return np.linalg.solve(M, right) + np.linalg.inv(M) @ right + K.dot(x) + np.linalg.norm(x) * np.linalg.det(M)

def text(t, x):
    return [-x[0] + 'one']
"""
GRADER = """
'''Exam: grade_order(fixed, p); grade_batch(batch): batch(x0s, t1, n) for the problem 'decay'.'''
import math
import numpy as np
import problems as pr

def smooth():
    yield 'decay', pr.decay(pr.Plain), np.array([1.0]), [1.0, 2.0], np.array([[math.exp(-1.0)], [math.exp(-2.0)]])

def grade_adaptive(integrate, verbose=True):
    cases = []
    for name, f, x0, times, exact in smooth():
        error = float(np.abs(integrate(f, x0, times, 1e-8, 1e-8) - exact).max())
        print('the grader saw', name)
        outcome = 'pass' if error < LIMIT else 'FAIL'
        cases.append(dict(id=name, errors=[error], limits=[LIMIT], outcome=outcome))
    return dict(passed=all(case['outcome'] == 'pass' for case in cases), cases=cases)

def grade_order(fixed, p):
    cases = []
    for name, f, x0, times, exact in smooth():
        errors = [float(np.abs(fixed(f, x0, times[0], n) - exact[0]).max()) for n in (8, 16)]
        order = math.log2(errors[0] / errors[1])
        cases.append(dict(id=name, order=order, outcome='pass' if abs(order - p) < 0.1 else 'FAIL'))
    return dict(passed=all(case['outcome'] == 'pass' for case in cases), cases=cases)

def grade_discontinuous(sim):
    t, x = sim(pr.JUMP, np.array([1.0]), 1.0, 0.01, 'jump')
    ok = bool(np.isfinite(x).all()) and len(t) == 101
    return dict(passed=ok, cases=[dict(id='jump', dev_over_h=[0.5], bound=2.0, outcome='pass' if ok else 'FAIL')])

def grade_batch(batch):
    starts = np.array([[1.0], [2.0], [np.nan]])
    ends = batch(starts, 1.0, 50)
    differences = dict(alone=float(np.abs(ends[1] - batch(starts[1:2], 1.0, 50)[0]).max()), kept=float(len(ends) - 3))
    return dict(passed=all(value == 0 for value in differences.values()), diffs=differences)
"""
