"""Studies to copy (`first.py`, `own_plant.py`, `own_law.py`, `own_study.py`), and a folder for each long study.

Run one by `workbench run studies/NAME`. What several studies of the paper share is in `paper`.
"""
