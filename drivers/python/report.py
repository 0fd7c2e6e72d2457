#!/usr/bin/python3
"""Makes the report of a study: see ductile/paper/making.py.

As a file of its own, so that no directory from which it is called can hide a module that it needs.
"""
import sys

sys.dont_write_bytecode = True  # the package may lie where nobody is to write

from ductile.paper.making import main

if __name__ == "__main__":
    sys.exit(main())
