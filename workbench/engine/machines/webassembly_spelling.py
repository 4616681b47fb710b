"""The browser's spelling: LLVM's for one run at a time, without the product that is rounded together with a sum."""

from __future__ import annotations

from collections.abc import Mapping

from workbench.engine.machines.llvm_spelling import instructions

WIDTH = 1  # runs side by side: a page turns one knob of one run at a time
TRIPLE = "wasm32-unknown-unknown"
FEATURES = "+bulk-memory,+nontrapping-fptoint,+sign-ext"
MISSING_OPERATIONS = ("fma",)  # WebAssembly has none, and a call of a library is refused
SPELLING: Mapping[str, str] = {
    name: text for name, text in instructions(WIDTH).items() if name not in MISSING_OPERATIONS
}
