// Times the stages that the library announces.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "voropack/observer.h"
#include "voropack/pipeline.h"

namespace voropack::app {

/// Passes everything on to another observer, and adds the seconds of each stage to a table.
class StageClock : public Observer {
 public:
  StageClock(Observer& next, StageTimes& times) : next_(next), times_(times) {}
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  ~StageClock() override { stop(); }

  void begin_stage(std::string_view name) override {
    stop();
    stage_ = name;
    start_ = Clock::now();
    next_.begin_stage(name);
  }
  void progress(std::uint64_t done, std::uint64_t total) override { next_.progress(done, total); }
  void log(LogLevel level, std::string_view message) override { next_.log(level, message); }
  [[nodiscard]] bool cancelled() const override { return next_.cancelled(); }

  /// Ends the current stage.
  void stop() {
    if (!stage_.empty()) times_[stage_] += std::chrono::duration<double>(Clock::now() - start_).count();
    stage_.clear();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Observer& next_;
  StageTimes& times_;
  std::string stage_;
  Clock::time_point start_;
};

}  // namespace voropack::app
