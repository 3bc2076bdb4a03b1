// The least that a test program needs: counted checks, and a closing line.
#pragma once

#include <cstdio>
#include <exception>

namespace check {

inline int passed = 0;
inline int failed = 0;

inline void that(bool holds, const char* what, const char* file, int line) {
  ++(holds ? passed : failed);
  if (!holds && failed <= 20) std::printf("%s:%d: %s\n", file, line, what);
}

template <class Test>
void run(const char* name, Test test) {
  try {
    test();
  } catch (const std::exception& error) {
    ++failed;
    std::printf("%s threw: %s\n", name, error.what());
  }
}

inline int report() {
  std::printf("%d passed, %d failed\n", passed, failed);
  return failed == 0 ? 0 : 1;
}

}  // namespace check

#define CHECK(condition) check::that((condition), #condition, __FILE__, __LINE__)
#define RUN(test) check::run(#test, test)
