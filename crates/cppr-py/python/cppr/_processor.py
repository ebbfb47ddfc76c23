"""Whether this processor has the instructions that the compiled part of the package uses: without them its import would end Python without a word."""

import ctypes
from importlib.util import find_spec

_spec = find_spec("cppr._cppr")
if _spec and _spec.origin:
    _lacks = ctypes.CDLL(_spec.origin).cppr_processor_lacks
    _lacks.restype = ctypes.c_bool
    if _lacks():
        raise ImportError(
            "this cppr is compiled for processors with AVX2 (most since 2015), which this one has not; with Rust installed, "
            'RUSTFLAGS="" pip install --no-binary cppr cppr compiles it for any'
        )
