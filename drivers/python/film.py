#!/usr/bin/python3
"""Makes films of results, with the package that lies beside it: see ductile/films.py.

As a file of its own, so that no directory from which it is called can hide a module that it needs.
"""
import sys

sys.dont_write_bytecode = True  # the package may lie where nobody is to write

from ductile.films import main

if __name__ == "__main__":
    sys.exit(main())
