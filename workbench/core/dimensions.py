"""Units of derivatives and of gains, as text."""

from __future__ import annotations

import re

from workbench.core.port import ANY

SECONDS = re.compile(r"/s(?:\^(\d+))?$")


def per_second(unit: str, order: int = 1) -> str:
    """The unit of a derivative: of 'rad' 'rad/s', of 'm/s' with order 2 'm/s^3', of 'm, rad' 'm/s, rad/s'."""
    return ", ".join(each if each == ANY else _over(*_split(each, order)) for each in unit.split(", "))


def gain(out: str, of: str, seconds: int = 0) -> str:
    """The unit of a gain from signals in `of` to signals in `out`, times a power of s: 'V' of 'rad/s' is 'V s/rad'."""
    outs, ofs = out.split(", "), of.split(", ")
    count = max(len(outs), len(ofs))
    return ", ".join(_gain(outs[i % len(outs)], ofs[i % len(ofs)], seconds) for i in range(count))


def _gain(out: str, of: str, seconds: int) -> str:
    if ANY in (out, of):
        return ANY
    base, order = _split(of, 0)
    power = order + seconds
    top = " ".join(filter(None, (out, _power(power) if power > 0 else "")))
    below = [f"({base})" if "/" in base else base, _power(-power) if power < 0 else ""]
    bottom = " ".join(filter(None, below))
    return f"{top or '1'}/{f'({bottom})' if ' ' in bottom else bottom}" if bottom else top


def _split(unit: str, order: int) -> tuple[str, int]:
    """A unit without the seconds that it ends in, and their power, `order` more."""
    found = SECONDS.search(unit)
    base = unit[: found.start()] if found else unit
    return "" if base == "1" else base, order + (int(found[1] or 1) if found else 0)


def _over(base: str, order: int) -> str:
    return f"{base or '1'}/{_power(order)}"


def _power(order: int) -> str:
    return "s" if order == 1 else f"s^{order}"
