"""The rules SIMC, AMIGO and lambda, from a model with one or two lags and a delay, with the margins that they give."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from workbench.core.validation.refusals import finite, positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError, one_thread
from workbench.design.pid_design.pi_optimum import checked_process
from workbench.design.pid_design.pid_designs import PidDesign, certificate_of, law_of_error
from workbench.design.pid_design.step_model import StepModel

if TYPE_CHECKING:
    import control

FILTER = 10.0  # N over 1 / Td
CALLS = {"SIMC": "simc", "AMIGO": "amigo", "lambda": "lambda_tuning"}


@check_arguments
def simc(
    plant: control.TransferFunction | control.StateSpace,
    model: StepModel,
    tau_c: float | None = None,
    delay: float = 0.0,
) -> PidDesign:
    """Skogestad's rule (SIMC) for a model: a PI law, or a PID law if the model has a second lag.

        Kc = T / (K (tau_c + L)),      Ti = min(T, 4 (tau_c + L)),      Td = T2

    in the series form; the gains of the result are those of the parallel form. A PID law has the filter N = 10/Td.

    Parameters
    ----------
    plant, delay
        The plant on which the law is checked, and its delay in s.
    model
        The model, of `half_rule_model` or `step_model`.
    tau_c
        The wanted time constant of the closed loop in s; by default the delay of the model.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    DesignError
        If tau_c + L is 0, or the loop is not stable.

    References
    ----------
    Skogestad (2003), J. Process Control 13, equations 23 to 25.

    Examples
    --------
    >>> import control
    >>> plant = control.tf([1], [1, 3, 3, 1])
    >>> design = wb.pid_design.simc(plant, wb.pid_design.half_rule_model(plant))
    >>> round(design.k, 3), round(design.Ti, 3)
    (0.5, 1.5)
    """
    wait = model.L if tau_c is None else finite("simc(tau_c=...)", tau_c, " of s", low=0)
    if not wait + model.L > 0:
        raise DesignError(
            "`simc(model, tau_c)`: the model has no delay and tau_c is 0, so the gain would be infinite. Give tau_c."
        )
    Kc = 1 / (model.slope * (wait + model.L)) if model.slope != math.inf else 0.0
    Ti = min(model.T, 4 * (wait + model.L))
    if model.T == 0:  # a pure delay: an integral law, Kc / Ti = 1 / (K (tau_c + L))
        return _checked("SIMC", plant, delay, (0.0, 1 / (model.K * (wait + model.L)), 0.0), None)
    if not model.T2:
        return _checked("SIMC", plant, delay, (Kc, Kc / Ti, 0.0), None)
    Td = model.T2
    gains = Kc * (1 + Td / Ti), Kc / Ti, Kc * Td
    return _checked("SIMC", plant, delay, gains, FILTER / Td)


@check_arguments
def lambda_tuning(
    plant: control.TransferFunction | control.StateSpace, model: StepModel, tau_c: float, delay: float = 0.0
) -> PidDesign:
    """Lambda tuning: the PI law that cancels the lag of a model and gives the closed loop the time constant tau_c.

        Kc = T / (K (tau_c + L)),      Ti = T

    Parameters
    ----------
    plant, model, delay
        As for `simc`; the model must not integrate.
    tau_c
        The wanted time constant of the closed loop in s, positive.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    DesignError
        If the model integrates, or the loop is not stable.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control.

    Examples
    --------
    >>> import control
    >>> plant = control.tf([1], [2, 1])
    >>> model = wb.pid_design.half_rule_model(plant, delay=1.0)
    >>> wb.pid_design.lambda_tuning(plant, model, tau_c=3.0, delay=1.0).k
    0.5
    """
    wait = positive("lambda_tuning(tau_c=...)", tau_c, " of s")
    if model.integrating:
        raise DesignError(
            "`lambda_tuning(model)` cancels a lag, and this model integrates, so the law would have no integral. Take "
            "`simc`."
        )
    ki = 1 / (model.K * (wait + model.L))
    return _checked("lambda", plant, delay, (model.T * ki, ki, 0.0), None)


@check_arguments
def amigo(
    plant: control.TransferFunction | control.StateSpace, model: StepModel, form: str = "PI", delay: float = 0.0
) -> PidDesign:
    """The rule AMIGO for a model K exp(-L s)/(T s + 1), or K exp(-L s)/s, which aims at Ms = Mt = 1.4.

    PI:   Kc = 0.15/K + (0.35 - L T/(L + T)^2) T/(K L),   Ti = 0.35 L + 13 L T^2/(T^2 + 12 L T + 7 L^2)
    PID:  Kc = (0.2 + 0.45 T/L)/K,   Ti = (0.4 L + 0.8 T)/(L + 0.1 T) L,   Td = 0.5 L T/(0.3 L + T)

    Parameters
    ----------
    plant, model, delay
        As for `simc`; the model has one lag and a delay that is not 0.
    form
        "PI" or "PID"; the filter of the PID law is N = 10/Td.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    DesignError
        If the model has no delay, or the loop is not stable.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control, equations 7.5, 7.7 and 7.10 to 7.13; Hagglund and Astrom (2004),
    Revisiting the Ziegler-Nichols tuning rules for PI control, part II, Asian J. Control 6.

    Examples
    --------
    >>> import control
    >>> plant = control.tf([1], [1, 1])
    >>> model = wb.pid_design.half_rule_model(plant, delay=1.0)
    >>> round(wb.pid_design.amigo(plant, model, delay=1.0).k, 3)
    0.25
    """
    if form not in ("PI", "PID"):
        raise ValueError(f"`amigo(form=...)` must be 'PI' or 'PID'; got {form!r}.")
    K, T, L = model.K, model.T, model.L
    if not L > 0 or model.T2:
        raise DesignError(
            "`amigo(model)` takes a model with one lag and a delay, as its gains are over the delay; this one has "
            f"L = {L:g} s and T2 = {model.T2:g} s. Take `half_rule_model(plant, order=1)`, or `simc`."
        )
    if form == "PI":
        if model.integrating:
            Kc, Ti = 0.35 / (K * L), 13.4 * L
        else:
            Kc = 0.15 / K + (0.35 - L * T / (L + T) ** 2) * T / (K * L)
            Ti = 0.35 * L + 13 * L * T**2 / (T**2 + 12 * L * T + 7 * L**2)
        return _checked("AMIGO", plant, delay, (Kc, Kc / Ti, 0.0), None)
    if model.integrating:
        Kc, Ti, Td = 0.45 / (K * L), 8 * L, 0.5 * L
    else:
        Kc, Ti = (0.2 + 0.45 * T / L) / K, (0.4 * L + 0.8 * T) / (L + 0.1 * T) * L
        Td = 0.5 * L * T / (0.3 * L + T)
    if Td == 0:
        return _checked("AMIGO", plant, delay, (Kc, Kc / Ti, 0.0), None)
    return _checked("AMIGO", plant, delay, (Kc, Kc / Ti, Kc * Td), FILTER / Td)


def _checked(
    method: str, plant: control.LTI, delay: float, gains: tuple[float, float, float], N: float | None
) -> PidDesign:
    """The design of a rule with the margins of its loop; one that is not stable is refused."""
    call = CALLS[method]
    process = checked_process(call, plant, delay)
    k, ki, kd = map(float, gains)
    with one_thread():
        certificate = certificate_of(plant, process.delay, law_of_error(k, ki, kd, N, plant))
    if not certificate.stable:
        raise DesignError(
            f"`{call}(plant, model)`: the loop of the plant and the law k = {k:.4g}, ki = {ki:.4g}, "
            f"kd = {kd:.4g} is not stable, so the model does not stand for the plant. Take `pi_optimum`."
        )
    return PidDesign(method, k, ki, kd, N, 1.0, 0.0, math.inf, math.inf, certificate, None, (), plant, process.delay)
