// Keep the arrays alive that `CornerRows` looks at, as an object of Python.
#pragma once

#include "bindings/cast.hpp"
#include "mesh/corner_rows.hpp"

namespace bldsimp {

struct RowArrays {
  Input<Face> input;
  Input<Index> point_of_row, source, class_of_row;
};

}  // namespace bldsimp

namespace nanobind::detail {

// None, where an argument may be that, is a mesh of no file.
template <>
struct type_caster<bldsimp::CornerRows> {
  NB_TYPE_CASTER(bldsimp::CornerRows, make_caster<bldsimp::RowArrays>::Name)
  template <class CastFlags>
  bool from_python(handle source, CastFlags, cleanup_list*) noexcept {
    if (source.is_none()) return true;
    const bldsimp::RowArrays* arrays = nullptr;
    if (!try_cast(source, arrays)) return false;
    value = {bldsimp::view<bldsimp::Face>(arrays->input), bldsimp::view<bldsimp::Index>(arrays->point_of_row),
             bldsimp::view<bldsimp::Index>(arrays->source), bldsimp::view<bldsimp::Index>(arrays->class_of_row)};
    return true;
  }
};

}  // namespace nanobind::detail
