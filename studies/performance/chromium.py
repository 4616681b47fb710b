"""A browser for measurements and tests: headless Chromium over a pair of pipes, without another package.

    with open_page(path) as page:
        page.press("#knob-0", "ArrowRight")
        assert page.value("document.title") == "..."

Messages of its debugging protocol are JSON, each ended by a zero byte; Chromium reads them from its file 3 and writes
them to its file 4.
"""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

PATIENCE = 30.0  # s until an answer must be there
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
)
KEYS = {
    "ArrowLeft": 37,
    "ArrowUp": 38,
    "ArrowRight": 39,
    "ArrowDown": 40,
    "Home": 36,
    "End": 35,
    "Escape": 27,
    "Enter": 13,
    "Tab": 9,
    "PageUp": 33,
}


def program() -> str | None:
    """The path of Chromium on this machine, if there is one."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Browser:
    """A browser that was started, and the pipes to it."""

    def __init__(self, folder: str) -> None:
        self.count, self.rest = 0, b""
        self.events: list[dict[str, Any]] = []
        here_out, there_in = self._pipe()
        there_out, here_in = self._pipe()
        self.send_to, self.read_from = there_in, there_out
        path = program()
        assert path
        line = [path, *FLAGS, f"--user-data-dir={folder}", "about:blank"]
        null = os.open(os.devnull, os.O_RDWR)
        files = [(os.POSIX_SPAWN_DUP2, here_out, 3), (os.POSIX_SPAWN_DUP2, here_in, 4)]
        files += [(os.POSIX_SPAWN_DUP2, null, number) for number in (0, 1, 2)]
        self.process = os.posix_spawn(path, line, dict(os.environ), file_actions=files, setpgroup=0)
        for number in (here_out, here_in, null):
            os.close(number)

    @staticmethod
    def _pipe() -> tuple[int, int]:
        """A pipe whose two numbers are out of the way of those that Chromium uses."""
        ends = os.pipe()
        moved = tuple(fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends)
        for end in ends:
            os.close(end)
        return moved[0], moved[1]

    def call(self, method: str, session: str | None = None, **parameters: Any) -> dict[str, Any]:
        """The answer to a command; what the browser tells meanwhile is kept in `events`."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.send_to, data) :]
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for told in self.listen(end - time.monotonic()):
                if told.get("id") == self.count:
                    if "error" in told:
                        raise RuntimeError(f"{method}: {told['error']}")
                    return dict(told["result"])
        raise TimeoutError(f"no answer to {method} in {PATIENCE:g} s")

    def listen(self, patience: float) -> list[dict[str, Any]]:
        """The messages that come next, at most so many s from now; the events among them are kept."""
        if not select.select([self.read_from], [], [], max(0.0, patience))[0]:
            return []
        data = os.read(self.read_from, 1 << 20)
        if not data:
            raise RuntimeError("Chromium has ended")
        *whole, self.rest = (self.rest + data).split(b"\0")
        messages = [json.loads(text) for text in whole]
        self.events += [message for message in messages if "method" in message]
        return messages

    def close(self) -> None:
        """End the browser and all its processes."""
        os.close(self.send_to)
        os.close(self.read_from)
        os.killpg(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)


class Page:
    """A page in a browser, which a test looks at, listens to, and turns."""

    def __init__(self, browser: Browser, target: str | None = None) -> None:
        self.browser = browser
        self.target = target or browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=self.target, flatten=True)["sessionId"]
        for room in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{room}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a command about this page."""
        return self.browser.call(method, self.session, **parameters)

    def open(self, address: str) -> None:
        """Go to an address and wait until the page is there."""
        before = len(self.events("Page.loadEventFired"))
        self.call("Page.navigate", url=address)
        end = time.monotonic() + PATIENCE
        while len(self.events("Page.loadEventFired")) == before:
            if time.monotonic() > end:
                raise TimeoutError(f"{address} was not there in {PATIENCE:g} s")
            self.browser.listen(0.1)

    def frame(self) -> Page:
        """The page in its sandboxed frame, which is a page of its own."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for info in self.browser.call("Target.getTargets")["targetInfos"]:
                if info["type"] == "iframe":
                    return Page(self.browser, info["targetId"])
            time.sleep(0.02)
        raise TimeoutError(f"no frame in {PATIENCE:g} s")

    def events(self, method: str) -> list[dict[str, Any]]:
        """The events of one kind that this page has told of."""
        mine = (event for event in self.browser.events if event.get("sessionId") == self.session)
        return [event["params"] for event in mine if event["method"] == method]

    @property
    def complaints(self) -> list[str]:
        """All errors, warnings and exceptions of its console."""
        thrown = [
            event["exceptionDetails"]["text"]
            + " "
            + event["exceptionDetails"].get("exception", {}).get("description", "")
            for event in self.events("Runtime.exceptionThrown")
        ]
        logged = [
            e["entry"]["text"] for e in self.events("Log.entryAdded") if e["entry"]["level"] in ("error", "warning")
        ]
        calls = [str(e["args"]) for e in self.events("Runtime.consoleAPICalled") if e["type"] in ("error", "warning")]
        return thrown + logged + calls

    @property
    def requests(self) -> list[str]:
        """The addresses that it asked for, without what it holds itself."""
        asked = [event["request"]["url"] for event in self.events("Network.requestWillBeSent")]
        return [address for address in asked if not address.startswith(("data:", "blob:"))]

    def value(self, expression: str) -> Any:
        """The value of an expression, which may be a promise, as plain data."""
        told = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in told:
            details = told["exceptionDetails"]
            raise RuntimeError(details.get("exception", {}).get("description", details["text"]))
        return told["result"].get("value")

    def until(self, expression: str, patience: float = PATIENCE) -> Any:
        """The value of an expression as soon as it is true."""
        end = time.monotonic() + patience
        while not (found := self.value(expression)):
            if time.monotonic() > end:
                raise TimeoutError(f"not true in {patience:g} s: {expression}")
            time.sleep(0.02)
        return found

    def size(self, width: int, height: int, dark: bool = False, calm: bool = False, touch: bool = False) -> None:
        """The size of the window in px, and what its reader prefers: the dark, no motion, fingers."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)
        features = [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
            {"name": "prefers-reduced-motion", "value": "reduce" if calm else "no-preference"},
        ]
        self.call("Emulation.setEmulatedMedia", features=features)

    def picture(self, path: Path) -> Path:
        """A picture of the window, as PNG."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))
        return path

    def press(self, selector: str, key: str, times: int = 1) -> None:
        """Press a key some times on the element that a selector finds."""
        self.value(f"document.querySelector({json.dumps(selector)}).focus()")
        for kind in ("keyDown", "keyUp") * times:
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=KEYS[key])

    def click(self, selector: str) -> None:
        """Click in the middle of the element that a selector finds."""
        x, y = self.middle(selector)
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def middle(self, selector: str) -> tuple[float, float]:
        """The middle of an element in the window, after it was brought there."""
        box = self.value(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)});"
            " e.scrollIntoView({block: 'nearest'}); const b = e.getBoundingClientRect();"
            " return [b.x + b.width / 2, b.y + b.height / 2]; })()"
        )
        return float(box[0]), float(box[1])


@contextmanager
def open_browser() -> Iterator[Browser]:
    """A browser with an empty profile."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = Browser(folder)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def open_page(
    path: Path, fragment: str = "", width: int = 1100, height: int = 800, browser: Browser | None = None
) -> Iterator[Page]:
    """A page of a file, in a browser of its own if none is given."""
    with nullcontext(browser) if browser else open_browser() as within:
        page = Page(within)
        page.size(width, height)
        page.open(path.resolve().as_uri() + fragment)
        yield page
        within.call("Target.closeTarget", targetId=page.target)
