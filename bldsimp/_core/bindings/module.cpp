// Define the module `_core`. The files beside this one are the only ones that know Python.
#include "bindings/cast.hpp"
#include "mesh/errors.hpp"
#include "mesh/parallel.hpp"

NB_MODULE(_core, m) {
  m.doc() = "bldsimp's kernels";
  nb::exception<bldsimp::InternalError>(m, "KernelError");
  m.def(
      "limit_threads",
      [](std::size_t most) {
        if (most == 0) throw nb::value_error("at least one thread");
        bldsimp::most_threads = most;
      },
      "most"_a);
  bldsimp::bind_mesh(m);
  bldsimp::bind_planar(m);
  bldsimp::bind_collapse(m);
  bldsimp::bind_cdt(m);
}
