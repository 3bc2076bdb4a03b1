// Report a broken invariant: the one error that kernels throw.
#pragma once

#include <stdexcept>
#include <string>

namespace bldsimp {

// An invariant of a kernel does not hold: a bug of ours, or an argument that breaks a precondition. The text is
// "stage: message", where the stage is the name of the function that Python calls.
class InternalError : public std::logic_error {
 public:
  InternalError(const std::string& stage, const std::string& message) : std::logic_error(stage + ": " + message) {}
};

}  // namespace bldsimp
