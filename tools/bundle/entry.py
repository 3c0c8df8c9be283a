"""Start of the stand-alone program and of its worker processes."""

import multiprocessing
import runpy

if __name__ == "__main__":
    multiprocessing.freeze_support()  # a worker process goes no further
    runpy.run_module("stereotrack_app", run_name="__main__", alter_sys=True)
