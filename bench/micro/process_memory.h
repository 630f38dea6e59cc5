// Memory of the whole process.
#pragma once

#include <malloc.h>
#include <sys/resource.h>

namespace voropack::bench {

/// As the program does: freed memory is kept for what comes next.
inline void keep_freed_memory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
}

/// The most that was in use at one time.
inline double peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace voropack::bench
