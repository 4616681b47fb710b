"""The ledger of a study: its chunks of numbers on the disk, each durable before it is acknowledged.

The room knows bytes, digests and folders, and nothing of loops. Read `chunk` first, then `store` and `resume`.
"""
