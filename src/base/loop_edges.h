// What the thread sanitizer cannot see of TBB: that a parallel loop begins after what came before it and ends before
// what follows.
#pragma once

#if defined(__SANITIZE_THREAD__)
#include <atomic>
#endif

namespace voropack {

#if defined(__SANITIZE_THREAD__)
inline constexpr bool kThreadSanitizer = true;

/// The library of TBB is not instrumented, so its forks and joins are told to the sanitizer here. The parts of a loop
/// are deliberately not ordered among each other: a race between them is reported.
class LoopEdges {
 public:
  LoopEdges() { begun_.store(1, std::memory_order_release); }
  void join() const { static_cast<void>(ended_.load(std::memory_order_acquire)); }

  /// Lives as long as one part of the loop runs.
  class Part {
   public:
    explicit Part(LoopEdges& loop) : loop_(loop) { static_cast<void>(loop_.begun_.load(std::memory_order_acquire)); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;
    ~Part() { loop_.ended_.fetch_add(1, std::memory_order_release); }

   private:
    LoopEdges& loop_;
  };

 private:
  std::atomic<int> begun_{0}, ended_{0};
};
#else
inline constexpr bool kThreadSanitizer = false;

class LoopEdges {
 public:
  void join() const {}
  class Part {
   public:
    explicit Part(LoopEdges& /*loop*/) {}
  };
};
#endif

}  // namespace voropack
