"""The machines that evaluate a graph: one table of operations, and for each language a file that spells them.

`operations` has a row for each operation, and `functions` makes what no processor has, as the sine, of the others. A
spelling has a line for each operation: `llvm_spelling` (this processor), `webassembly_spelling` (a browser),
`numpy_spelling`, `c_spelling` and `python_spelling`. Read `operations` first, then `machine`.
"""
