"""The kind `logs` of the exam of identification: a CSV text is read and checked, and fitted if it may be.

The fit is that of the kinds `clean` and `noisy`; a log is flagged if it warns that the model does not explain the log.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import workbench as wb
from workbench.identification.datasets import DataCheck

from . import identify_fits

PERIODS = {"h": 3600.0, "min": 60.0}


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The verdict on a log, the reason for it, and the parameters where they can be had."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.csv")
        path.write_text(case["csv"], encoding="utf-8")
        try:
            log = wb.Dataset.from_csv(path)
        except (ValueError, LookupError) as refusal:
            return {"verdict": "refused", "reason": str(refusal)}
    inputs = [name.partition(":")[0] for name in case["inputs"]]
    units = dict(name.split(":") for name in (*case["states"], *case["inputs"]))
    log, check = _checked(log, case, inputs, units)
    if not check.is_passed and check.open_findings[0].severity == "refused":
        return {"verdict": "refused", "reason": check.open_findings[0].text}
    answer: dict[str, Any] = {"verdict": "accepted", "reason": ""}
    if check.open_findings:
        answer = {"verdict": "flagged", "reason": check.open_findings[0].text}
    try:
        fit = _fitted(log, case, inputs)
    except (ValueError, LookupError) as refusal:  # of a log with a question that bars it, such as a lost sample
        return answer | {"reason": answer["reason"] or str(refusal), "verdict": "refused"}
    misfit = [warning for warning in fit["warnings"] if "explain" in warning]
    if misfit and not answer["reason"]:
        answer = {"verdict": "flagged", "reason": misfit[0]}
    return answer | {"parameters": fit["parameters"]}


def _checked(
    log: wb.Dataset, case: dict[str, Any], inputs: list[str], units: dict[str, str]
) -> tuple[wb.Dataset, DataCheck]:
    """The log, with scaled units converted as the check advises, and its check."""
    for _ in range(2):
        check = wb.check_data(
            log,
            inputs=inputs,
            outputs=list(case["outputs"]),
            parameters=list(case["parameters"]),
            rate=case["rate_hz"],
            units=units,
        )
        if not (scaled := {one.signal: units[one.signal] for one in check.findings if one.point == "unit scaled"}):
            break
        log = log.convert(scaled)
    return log, check


def _fitted(log: wb.Dataset, case: dict[str, Any], inputs: list[str]) -> dict[str, Any]:
    """The answer of the fit of a log."""
    record = log.select([*inputs, *case["outputs"]]).experiments[0]
    t = record.t / _seconds_of_model(case)
    count = len(inputs)
    parts = {"t": t, "tu": t, "u": record.values[:, :count], "y": record.values[:, count:]}
    kind = "clean" if case["sigma"] is None else "noisy"
    return identify_fits.solve(case | parts | {"kind": kind})


def _seconds_of_model(case: dict[str, Any]) -> float:
    """The unit of time of a model in s: of one whose rates are per hour, 3600."""
    texts = [unit for _, unit in case["parameters"].values()] + [name.partition(":")[2] for name in case["inputs"]]
    words = {word for text in texts for word in "".join(c if c.isalpha() else " " for c in text).split()}
    return 1.0 if "s" in words else next((PERIODS[unit] for unit in PERIODS if unit in words), 1.0)
