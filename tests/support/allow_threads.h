// Lets a test use more threads than the machine has, so that threads also meet on small machines.
#pragma once

#include <tbb/global_control.h>

#include <cstddef>

namespace voropack::test {

/// While it lives, parallel loops of this process may use up to `n` threads.
class AllowThreads {
 public:
  explicit AllowThreads(std::size_t n) : control_(tbb::global_control::max_allowed_parallelism, n) {}

 private:
  tbb::global_control control_;
};

}  // namespace voropack::test
