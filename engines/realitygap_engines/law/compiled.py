"""Functions compiled by numba, with a cache that sees a change in any function or number that they use.

Numba's own cache looks at the file of the compiled function only: a change in a function that it calls from another
file leaves the old machine code in use. Here the key of the cache has the code of all of them.
"""

import hashlib
from collections.abc import Callable
from types import CellType, CodeType, FunctionType
from typing import Any

import numba
from numba.core.registry import CPUDispatcher


def compiled(function: Callable[..., Any], *, nogil: bool = False) -> Callable[..., Any]:
    """The function in machine code, division by zero as in numpy, cached on disk.

    The cache's key has a hash of what a function closes over, so the function is made to close over the digest of its
    code and of all that it uses by name. With `nogil` other threads run while it does, which is worth it for long calls
    only.
    """
    assert isinstance(function, FunctionType)
    code = function.__code__
    keyed = FunctionType(
        code.replace(co_freevars=(*code.co_freevars, "digest")),
        function.__globals__,
        function.__name__,
        function.__defaults__,
        (*(function.__closure__ or ()), CellType((code_digest(function), nogil))),
    )
    keyed.__doc__, keyed.__qualname__, keyed.__module__ = function.__doc__, function.__qualname__, function.__module__
    out: Callable[..., Any] = numba.njit(cache=True, nogil=nogil, error_model="numpy")(keyed)
    return out


def code_digest(function: FunctionType) -> str:
    """A digest of a function's code, of the compiled functions that it calls by name, and of the constants it names."""
    digest = hashlib.sha256()
    seen: set[FunctionType] = set()

    def add(function: FunctionType) -> None:
        if function in seen:
            return
        seen.add(function)
        code = function.__code__
        constants = [c.co_code if isinstance(c, CodeType) else c for c in code.co_consts]
        digest.update(code.co_code + repr((constants, code.co_names)).encode())
        for name in code.co_names:
            value = function.__globals__.get(name)
            if isinstance(value, CPUDispatcher):
                add(value.py_func)
            elif isinstance(value, bool | int | float | str | tuple):
                digest.update(f"{name}={value!r}".encode())

    add(function)
    return digest.hexdigest()
