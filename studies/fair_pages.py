from fair_laws import *


def sections(r):
    return ()


def headlines(r):
    return ()
