"""Start of the stand-alone program, of its worker processes, and of its modules."""

import multiprocessing
import sys

from stereotrack_core.own_program import asked_module, run_module

if __name__ == "__main__":
    multiprocessing.freeze_support()  # a worker process goes no further
    run_module(*(asked_module(sys.argv) or ("stereotrack_app", sys.argv[1:])))
