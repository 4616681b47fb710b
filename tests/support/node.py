"""JavaScript in one Node for all tests of a process, as each start of it takes a tenth of a second."""

import atexit
import json
import subprocess
from functools import cache

from tests.support.browsers import NODE

# Each line is a program, the body of a function, and what it finds as `given`; the answer is a line, too.
SERVER = """
const { createInterface } = require("readline");
globalThis.postMessage = () => {};
globalThis.onmessage = null;
createInterface({ input: process.stdin }).on("line", (line) => {
  const { program, given } = JSON.parse(line);
  let told;
  try {
    told = { answer: new Function("require", "given", program)(require, given) };
  } catch (error) {
    told = { error: error.stack };
  }
  process.stdout.write(JSON.stringify(told) + "\\n");
});
"""


@cache
def _server():
    node = subprocess.Popen(
        [NODE, "-e", SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8"
    )

    @atexit.register
    def end():
        node.kill()
        node.communicate()

    return node


def answered(program, given=None):
    """What the body of a function returns, which finds `given` under this name."""
    node = _server()
    node.stdin.write(json.dumps({"program": program, "given": given}, allow_nan=False) + "\n")
    node.stdin.flush()
    told = json.loads(node.stdout.readline())
    assert "error" not in told, told["error"]
    return told["answer"]
