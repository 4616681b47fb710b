"""The paper's tables: its equations run as printed and as repaired, beside the laws that it compares."""
