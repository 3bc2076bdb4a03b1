// The only file that knows Python: casts arrays at the boundary and calls the kernels.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

NB_MODULE(_core, m) { m.doc() = "bldsimp's kernels"; }
