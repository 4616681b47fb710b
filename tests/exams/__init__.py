"""The exams: independent graders, found in a folder by what they ask, and the workbench as the one who sits them.

python -m tests.exams ../shared/exams
"""
