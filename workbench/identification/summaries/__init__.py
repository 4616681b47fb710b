"""Summaries: a fit as plain data, which a ledger keeps and a page shows."""

from workbench.identification.summaries.fit_summary import FitSummary as FitSummary
