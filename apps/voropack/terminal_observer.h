// Follows a computation on standard error: messages, and a progress bar or a line every few seconds.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "voropack/observer.h"

namespace voropack::app {

struct Verbosity {
  bool quiet = false;        ///< Errors only.
  bool no_progress = false;  ///< Messages, but no bar and no lines of progress.
  bool verbose = false;      ///< Also what is said for debugging, and the time of each stage.
};

/// A thread of its own draws, so that a stage that reports seldom is still seen to be alive.
class TerminalObserver : public Observer {
 public:
  /// `on_overdue` is called once, from the drawing thread, if the work has not stopped within 0.7 s after an interrupt.
  TerminalObserver(const Verbosity& verbosity, std::function<void()> on_overdue);
  TerminalObserver(const TerminalObserver&) = delete;
  TerminalObserver& operator=(const TerminalObserver&) = delete;
  ~TerminalObserver() override;

  void begin_stage(std::string_view name) override;
  void progress(std::uint64_t done, std::uint64_t total) override;
  void log(LogLevel level, std::string_view message) override;
  [[nodiscard]] bool cancelled() const override;

  /// Ends the current stage and clears the bar, before results are printed.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  void draw_until_stopped();
  void draw(Clock::time_point now);
  void clear_bar();
  void end_stage();
  [[nodiscard]] std::string progress_text(Clock::time_point now) const;

  const Verbosity verbosity_;
  const bool is_terminal_;
  const std::function<void()> on_overdue_;

  std::atomic<std::uint64_t> done_{0};
  std::atomic<std::uint64_t> total_{0};

  std::mutex mutex_;  ///< Guards what follows and the order of lines.
  std::condition_variable wake_;
  bool stopping_ = false;
  bool bar_is_drawn_ = false;
  std::string stage_;
  Clock::time_point stage_start_ = Clock::now();
  Clock::time_point last_line_ = Clock::now();

  std::thread drawer_;  ///< Last, so that it starts when everything else is there.
};

/// "12,345,678": a count that a person can read.
std::string grouped(std::uint64_t count);

/// "1.23 M": a count in few digits.
std::string shortened(double count);

}  // namespace voropack::app
