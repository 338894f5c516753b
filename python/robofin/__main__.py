"""The program: `python -m robofin` is `robofin`."""

from ._program import main

main()
