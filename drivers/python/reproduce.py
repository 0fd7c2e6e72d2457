#!/usr/bin/python3
"""Computes the paper's study and lays it beside the paper: see ductile/paper/reproduce.py.

As a file of its own, so that no directory from which it is called can hide a module that it needs.
"""
import sys

sys.dont_write_bytecode = True  # the package may lie where nobody is to write

from ductile.paper.reproduce import main

if __name__ == "__main__":
    sys.exit(main())
