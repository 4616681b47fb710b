"""The usual structures by their names: ARX, ARMAX, output error and Box-Jenkins."""

from __future__ import annotations

from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.polynomial_estimates import Names, polynomial_model
from workbench.identification.linear_models.polynomial_model import PolynomialModel
from workbench.identification.linear_models.polynomial_structure import PolynomialStructure

Orders = int | tuple[int, ...]


@check_arguments
def arx(
    data: Dataset,
    inputs: Names,
    output: str,
    na: int,
    nb: Orders,
    nk: Orders = 1,
    *,
    holdout: Dataset | None = None,
    offsets: str = "estimate",
    initial: str = "estimate",
) -> PolynomialModel:
    """The model A y = sum B_i q^-nk_i u_i + e by linear least squares.

    The orders `nb`, `nk` and `nf` of several inputs are one number for all, or a tuple; all else is as for
    `polynomial_model`. If the true noise is not e/A, the estimate is biased, and the test of whiteness fails.

    Raises
    ------
    ValueError, LookupError
        As of `polynomial_model`.

    References
    ----------
    Ljung (1999), System Identification, equation 4.7 and section 10.1.

    Examples
    --------
    >>> t = 0.1 * np.arange(300)
    >>> u = np.random.default_rng(1).standard_normal(300)
    >>> y = np.convolve(u, [0.0, 1.0, 0.5])[:300]
    >>> log = wb.Dataset.of(t, {"u": u, "y": y}, {"u": "V", "y": "V"})
    >>> model = wb.linear_models.arx(log, "u", "y", na=0, nb=2)
    >>> {name: round(value, 6) for name, value in model.parameters.items()}
    {'b1': 1.0, 'b2': 0.5}
    """
    numerators, delays = _per_input("arx", inputs, nb=nb, nk=nk)
    structure = PolynomialStructure(na, numerators, 0, 0, (0,) * len(numerators), delays)
    return polynomial_model(data, inputs, output, structure, holdout=holdout, offsets=offsets, initial=initial)


@check_arguments
def armax(
    data: Dataset,
    inputs: Names,
    output: str,
    na: int,
    nb: Orders,
    nc: int,
    nk: Orders = 1,
    *,
    holdout: Dataset | None = None,
    offsets: str = "estimate",
    initial: str = "estimate",
    starts: int = 8,
    seed: int = 0,
) -> PolynomialModel:
    """The model A y = sum B_i q^-nk_i u_i + C e by prediction errors; arguments as of `arx` and `polynomial_model`.

    Raises
    ------
    ValueError, LookupError
        As of `polynomial_model`.

    References
    ----------
    Ljung (1999), System Identification, equation 4.14.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> u, e, y = rng.choice([-1.0, 1.0], 900), 0.1 * rng.standard_normal(900), np.zeros(900)
    >>> for k in range(1, 900):
    ...     y[k] = 0.8 * y[k - 1] + 0.5 * u[k - 1] + e[k] + 0.6 * e[k - 1]
    >>> log = wb.Dataset.of(0.1 * np.arange(900), {"u": u, "y": y}, {"u": "V", "y": "rad"})
    >>> model = wb.linear_models.armax(log, "u", "y", na=1, nb=1, nc=1)
    >>> {name: round(value, 1) for name, value in model.parameters.items()}
    {'a1': -0.8, 'b1': 0.5, 'c1': 0.6}
    """
    numerators, delays = _per_input("armax", inputs, nb=nb, nk=nk)
    structure = PolynomialStructure(na, numerators, nc, 0, (0,) * len(numerators), delays)
    return polynomial_model(
        data, inputs, output, structure, holdout=holdout, offsets=offsets, initial=initial, starts=starts, seed=seed
    )


@check_arguments
def output_error(
    data: Dataset,
    inputs: Names,
    output: str,
    nb: Orders,
    nf: Orders,
    nk: Orders = 1,
    *,
    holdout: Dataset | None = None,
    offsets: str = "estimate",
    initial: str = "estimate",
    starts: int = 8,
    seed: int = 0,
) -> PolynomialModel:
    """The model y = sum B_i/F_i q^-nk_i u_i + e by output errors; arguments as of `arx` and `polynomial_model`.

    In open loop B and F are consistent whatever the noise is. Their standard errors allow for coloured residuals by an
    autoregressive model of these. In closed loop with coloured noise they are biased: take `box_jenkins`.

    Raises
    ------
    ValueError, LookupError
        As of `polynomial_model`.

    References
    ----------
    Ljung (1999), System Identification, equation 4.25, theorem 8.4 and section 9.4.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> u, x = rng.choice([-1.0, 1.0], 900), np.zeros(900)
    >>> for k in range(1, 900):
    ...     x[k] = 0.8 * x[k - 1] + 0.5 * u[k - 1]
    >>> y = x + 0.1 * rng.standard_normal(900)
    >>> log = wb.Dataset.of(0.1 * np.arange(900), {"u": u, "y": y}, {"u": "V", "y": "rad"})
    >>> model = wb.linear_models.output_error(log, "u", "y", nb=1, nf=1)
    >>> {name: round(value, 1) for name, value in model.parameters.items()}
    {'b1': 0.5, 'f1': -0.8}
    """
    numerators, forks, delays = _per_input("output_error", inputs, nb=nb, nf=nf, nk=nk)
    structure = PolynomialStructure(0, numerators, 0, 0, forks, delays)
    return polynomial_model(
        data, inputs, output, structure, holdout=holdout, offsets=offsets, initial=initial, starts=starts, seed=seed
    )


@check_arguments
def box_jenkins(
    data: Dataset,
    inputs: Names,
    output: str,
    nb: Orders,
    nf: Orders,
    nc: int,
    nd: int,
    nk: Orders = 1,
    *,
    holdout: Dataset | None = None,
    offsets: str = "estimate",
    initial: str = "estimate",
    starts: int = 8,
    seed: int = 0,
) -> PolynomialModel:
    """The model y = sum B_i/F_i q^-nk_i u_i + C/D e by prediction errors; arguments as of `arx`, `polynomial_model`.

    Raises
    ------
    ValueError, LookupError
        As of `polynomial_model`.

    References
    ----------
    Ljung (1999), System Identification, equation 4.31.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> u, e, x, v = rng.choice([-1.0, 1.0], 900), 0.1 * rng.standard_normal(900), np.zeros(900), np.zeros(900)
    >>> for k in range(1, 900):
    ...     x[k], v[k] = 0.8 * x[k - 1] + 0.5 * u[k - 1], 0.6 * v[k - 1] + e[k]
    >>> log = wb.Dataset.of(0.1 * np.arange(900), {"u": u, "y": x + v}, {"u": "V", "y": "rad"})
    >>> model = wb.linear_models.box_jenkins(log, "u", "y", nb=1, nf=1, nc=0, nd=1)
    >>> {name: round(value, 1) for name, value in model.parameters.items()}
    {'b1': 0.5, 'd1': -0.6, 'f1': -0.8}
    """
    numerators, forks, delays = _per_input("box_jenkins", inputs, nb=nb, nf=nf, nk=nk)
    structure = PolynomialStructure(0, numerators, nc, nd, forks, delays)
    return polynomial_model(
        data, inputs, output, structure, holdout=holdout, offsets=offsets, initial=initial, starts=starts, seed=seed
    )


def _per_input(call: str, inputs: Names, **orders: Orders) -> list[tuple[int, ...]]:
    """Orders for each input; one number is for all."""
    count = 1 if isinstance(inputs, str) else len(inputs)
    rows = []
    for name, order in orders.items():
        row = (order,) * count if isinstance(order, int) else tuple(order)
        if len(row) != count:
            raise ValueError(f"`{call}({name}=...)` must have one order for each of {count} inputs; got {len(row)}.")
        rows.append(row)
    return rows
