"""Threads of linear algebra: processes that share the cores take one each."""

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables of the environment that say how many threads such a library takes; it reads them when it is loaded."""
