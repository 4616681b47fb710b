"""The ledger of a study: its numbers as chunks on the disk, so that a run that was killed loses none of them.

The room knows bytes, digests and folders, and nothing of loops or sweeps.
Read `chunk` first, then `store`, whose `Ledger` puts a chunk on the disk with the help of `durability`.
"""
