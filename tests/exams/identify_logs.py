"""The kind `logs` of the exam of identification: a CSV text is read and checked, and fitted if it may be.

The fit is `identify_fits.solve` for the kinds `clean` and `noisy`; its answer may have a `misfit`, the sentence that
says that the model does not explain the log. Without that file the verdict of the check stands alone.
"""

from __future__ import annotations

import tempfile
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import workbench as wb
from workbench.identification.datasets import DataCheck

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
    if (fit := _fitted(log, case, inputs)) is None:
        return answer
    if fit.get("misfit") and answer["verdict"] == "accepted":
        answer = {"verdict": "flagged", "reason": fit["misfit"]}
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


def _fitted(log: wb.Dataset, case: dict[str, Any], inputs: list[str]) -> dict[str, Any] | None:
    """The answer of the fit of a log, or None where no fit is there."""
    if not find_spec(f"{__package__}.identify_fits"):
        return None
    record = log.select([*inputs, *case["outputs"]]).experiments[0]
    t = record.t / _seconds_of_model(case)
    count = len(inputs)
    parts = {"t": t, "tu": t, "u": record.values[:, :count], "y": record.values[:, count:]}
    kind = "clean" if case["sigma"] is None else "noisy"
    answer: dict[str, Any] = import_module(".identify_fits", __package__).solve(case | parts | {"kind": kind})
    return answer


def _seconds_of_model(case: dict[str, Any]) -> float:
    """The unit of time of a model in s: of one whose rates are per hour, 3600."""
    texts = [unit for _, unit in case["parameters"].values()] + [name.partition(":")[2] for name in case["inputs"]]
    words = {word for text in texts for word in "".join(c if c.isalpha() else " " for c in text).split()}
    return 1.0 if "s" in words else next((PERIODS[unit] for unit in PERIODS if unit in words), 1.0)
