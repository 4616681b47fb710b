"""The handles of a live page's poles: where they are, and what drags them."""

import workbench as wb

SHOWN = "Boolean(document.querySelector('.live-pole:not([hidden])'))"
STILL = "livePage.handles.all.every(({pursuit}) => !pursuit.isSeeking && !pursuit.aim) && !livePage.late.size"


STILL += " && (!livePage.flight || !livePage.flight.fine.size) && !livePage.held && !livePage.away.size"


MAP = "livePage.handles.all.find((one) => one.records)"
POLES = f"{MAP}.records.filter(({{element}}) => !element.hidden).map(({{at}}) => [at.re, at.im])"
TOLD = f"[...{MAP}.row.querySelectorAll('span')].map((one) => one.textContent).join('')"
PLACED = 1e-6  # of a pole, as promised


def loop(**gains):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, **{"Kp": 100.0, "Ki": 200.0} | gains)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def poles(closed, **options):
    return [one.value for one in wb.linear_loop(closed, **options).poles if one.value.imag >= 0]


def nearest(all_poles, target):
    return min(all_poles, key=lambda one: abs(one - target))


def knobs(page):
    return page.value("Object.fromEntries(livePage.data.knobs.map(({name}, i) => [name, livePage.state.values[i]]))")


def gains(page):
    values = knobs(page)
    return {name: values[f"controller.{name}"] for name in ("Kp", "Ki", "Kd", "N")}


def drag(page, start, target):
    """Drag the pole nearest to a place to another place, and give the pole that came nearest to it."""
    page.value(f"""(() => {{
      const map = {MAP}, away = ({{at}}) => Math.hypot(at.re - {start.real}, at.im - {start.imag});
      const record = [...map.records].sort((a, b) => away(a) - away(b))[0];
      record.element.focus();
      return map.wish(record, {{re: {target.real}, im: {target.imag}}});
    }})()""")
    page.until(STILL)
    return nearest([complex(*one) for one in page.value(POLES)], target)
