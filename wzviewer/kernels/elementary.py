"""Elementary functions that the compiler can vectorise, and constants in float32.

numba promotes ``float32 * 0.5`` to float64, so each constant of a kernel is a named float32.  The
library's exp and log are scalar calls; these are polynomials (minimax fits on [0, 1] and [1, 2]).
"""

import threading

import numba
import numpy as np

from wzviewer.core import constants

FLAGS = {"reassoc", "contract", "nsz", "arcp", "nnan", "ninf"}  # where no nan or inf can arrive
SAFE_FLAGS = {"reassoc", "contract", "nsz", "arcp"}  # where data from outside is tested
ORDERED_FLAGS = FLAGS - {"reassoc"}
"""For long formulas: a loop is optimised once when compiled and once more for the cache, and sums that may be
reordered then differ between the first run and all later ones."""

ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
CUT = np.float32(constants.ALPHA_CUT)
MAX = np.float32(constants.ALPHA_MAX)
STOP = np.float32(constants.TRANSMITTANCE_STOP)
LOW_PASS = np.float32(constants.LOW_PASS_PX2)
LOG2_E = np.float32(np.log2(np.e))

# Surfels of one task.  A vector body and its scalar remainder round differently, so where a loop is cut
# must not depend on the number of threads.
BLOCK = 4096

# numba's portable threading layer ends the process when two threads enter parallel loops at once
KERNELS = threading.RLock()

_E1, _E2, _E3 = np.float32(0.69315131), np.float32(0.24016445), np.float32(0.05579991)
_E4, _E5 = np.float32(0.00901703), np.float32(0.00186713)
_L1, _L2, _L3 = np.float32(1.44268988), np.float32(-0.72116581), np.float32(0.47868369)
_L4, _L5, _L6 = np.float32(-0.34730106), np.float32(0.24186471), np.float32(-0.13752127)
_L7, _L8 = np.float32(0.05205895), np.float32(-0.00930915)
_LOWEST, _HIGHEST = np.float32(-125.0), np.float32(125.0)
_BIAS, _MANTISSA_BITS, _MANTISSA = np.int32(127), np.int32(23), np.int32(0x007FFFFF)
_EXPONENT_OF_ONE = np.int32(0x3F800000)


@numba.njit(fastmath=FLAGS)
def exp2(x: np.float32) -> np.float32:
    """Returns 2^x in float32, relative error 1e-7; x is limited to [-125, 125]."""
    x = min(max(x, _LOWEST), _HIGHEST)
    whole = np.floor(x)
    f = x - whole
    poly = ONE + f * (_E1 + f * (_E2 + f * (_E3 + f * (_E4 + f * _E5))))
    power = np.int32((np.int32(whole) + _BIAS) << _MANTISSA_BITS).view(np.float32)
    return poly * power


@numba.njit(fastmath=FLAGS)
def log2(x: np.float32) -> np.float32:
    """Returns log2 of a positive normal float32, absolute error 1e-7."""
    bits = np.float32(x).view(np.int32)
    whole = np.float32((bits >> _MANTISSA_BITS) - _BIAS)
    f = np.int32((bits & _MANTISSA) | _EXPONENT_OF_ONE).view(np.float32) - ONE
    high = _L5 + f * (_L6 + f * (_L7 + f * _L8))
    return whole + f * (_L1 + f * (_L2 + f * (_L3 + f * (_L4 + f * high))))
