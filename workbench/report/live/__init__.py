"""The live part of a report: what its page needs to run the loops of a study again, at numbers that a reader chooses.

The room knows results, kernels and documents, and gives plain data; it knows nothing of browsers and pages. A curve or
a cell of the document is live if its source is a signal or a score of a case. Read `knob` first, then `live_data`.
"""
