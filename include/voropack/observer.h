// How a caller follows and stops a computation. The library itself prints nothing.
#pragma once

#include <cstdint>
#include <string_view>

#include "voropack/error.h"

namespace voropack {

enum class LogLevel : std::uint8_t { kDebug, kInfo, kWarning };

/// Receives progress and messages; may ask to stop. Calls come from one thread at a time, but not always from the same.
class Observer {
 public:
  virtual ~Observer() = default;
  /// A stage begins, such as "packing".
  virtual void begin_stage(std::string_view /*name*/) {}
  /// `done` of `total` in the current stage; total is 0 where it is not known.
  virtual void progress(std::uint64_t /*done*/, std::uint64_t /*total*/) {}
  virtual void log(LogLevel, std::string_view /*message*/) {}
  /// True asks the computation to throw Cancelled soon. Called often, from any thread; must be cheap.
  [[nodiscard]] virtual bool cancelled() const { return false; }

  /// Throws Cancelled if the caller asked to stop.
  void check_cancelled() const {
    if (cancelled()) throw Cancelled();
  }
};

/// An observer that ignores everything.
Observer& silent_observer();

}  // namespace voropack
