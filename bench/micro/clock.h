// Wall-clock seconds, and those of all processors.
#pragma once

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <string>

namespace voropack::bench {

struct Seconds {
  double wall = 0, processor = 0;
  friend Seconds operator+(const Seconds& a, const Seconds& b) { return {a.wall + b.wall, a.processor + b.processor}; }
};

/// Begins when it is made.
class Clock {
 public:
  [[nodiscard]] Seconds passed() const {
    const Clock now;
    return {now.wall_ - wall_, now.processor_ - processor_};
  }
  [[nodiscard]] std::string text() const {
    const Seconds seconds = passed();
    return fmt::format("{:.2f} s, {:.2f} s of processor time", seconds.wall, seconds.processor);
  }

 private:
  static double seconds(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  static double processor() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  double wall_ = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  double processor_ = processor();
};

}  // namespace voropack::bench
