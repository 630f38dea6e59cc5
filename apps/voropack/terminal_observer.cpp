#include "terminal_observer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "interrupt.h"

namespace voropack::app {

namespace {

constexpr auto kTick = std::chrono::milliseconds(100);
constexpr auto kLineInterval = std::chrono::seconds(3);
constexpr auto kInterruptPatience = std::chrono::milliseconds(700);
constexpr int kBarWidth = 24;

bool stderr_is_terminal() {
  const char* const term = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && term != nullptr && std::string_view(term) != "dumb";
}

}  // namespace

std::string grouped(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string shortened(double count) {
  constexpr std::string_view kUnits = " kMGT";
  std::size_t unit = 0;
  while (count >= 999.5 && unit + 1 < kUnits.size()) {
    count /= 1000;
    ++unit;
  }
  return unit == 0 ? fmt::format("{:.0f}", count) : fmt::format("{:.3g} {}", count, kUnits[unit]);
}

TerminalObserver::TerminalObserver(const Verbosity& verbosity, std::function<void()> on_overdue)
    : verbosity_(verbosity),
      is_terminal_(stderr_is_terminal()),
      on_overdue_(std::move(on_overdue)),
      drawer_([this] { draw_until_stopped(); }) {}

TerminalObserver::~TerminalObserver() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
    end_stage();
  }
  wake_.notify_all();
  drawer_.join();
}

void TerminalObserver::begin_stage(std::string_view name) {
  const std::scoped_lock lock(mutex_);
  end_stage();
  stage_ = name;
  stage_start_ = Clock::now();
  done_ = 0;
  total_ = 0;
}

void TerminalObserver::progress(std::uint64_t done, std::uint64_t total) {
  done_.store(done, std::memory_order_relaxed);
  total_.store(total, std::memory_order_relaxed);
}

void TerminalObserver::log(LogLevel level, std::string_view message) {
  if (verbosity_.quiet || (level == LogLevel::kDebug && !verbosity_.verbose)) return;
  // What is not a warning tells how far the work is.
  if (level == LogLevel::kInfo && verbosity_.no_progress && !verbosity_.verbose) return;
  const std::scoped_lock lock(mutex_);
  clear_bar();
  const std::string_view prefix = level == LogLevel::kWarning ? "warning: " : "";
  fmt::print(stderr, "voropack: {}{}\n", prefix, message);
}

bool TerminalObserver::cancelled() const { return interrupt_signal() != 0; }

void TerminalObserver::finish() {
  const std::scoped_lock lock(mutex_);
  end_stage();
}

void TerminalObserver::draw_until_stopped() {
  std::unique_lock lock(mutex_);
  Clock::time_point interrupted_at = Clock::time_point::max();
  while (!stopping_) {
    wake_.wait_for(lock, kTick);
    const Clock::time_point now = Clock::now();
    if (interrupt_signal() != 0) {
      interrupted_at = std::min(interrupted_at, now);
      if (!stopping_ && now - interrupted_at > kInterruptPatience) {
        clear_bar();
        on_overdue_();
        return;
      }
    }
    if (!stopping_) draw(now);
  }
}

void TerminalObserver::draw(Clock::time_point now) {
  if (verbosity_.quiet || verbosity_.no_progress || stage_.empty()) return;
  if (is_terminal_) {
    fmt::print(stderr, "\r{}\x1b[K", progress_text(now));
    std::fflush(stderr);
    bar_is_drawn_ = true;
  } else if (now - last_line_ >= kLineInterval) {
    fmt::print(stderr, "{}\n", progress_text(now));
    last_line_ = now;
  }
}

void TerminalObserver::clear_bar() {
  if (!bar_is_drawn_) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
  bar_is_drawn_ = false;
}

void TerminalObserver::end_stage() {
  clear_bar();
  if (verbosity_.verbose && !verbosity_.quiet && !stage_.empty()) {
    const std::chrono::duration<double> elapsed = Clock::now() - stage_start_;
    fmt::print(stderr, "voropack: {} took {:.3f} s\n", stage_, elapsed.count());
  }
  stage_.clear();
}

std::string TerminalObserver::progress_text(Clock::time_point now) const {
  const std::uint64_t done = done_.load(std::memory_order_relaxed), total = total_.load(std::memory_order_relaxed);
  const double elapsed = std::chrono::duration<double>(now - stage_start_).count();
  std::string text = fmt::format("{:<12}", stage_);
  if (total > 0) {
    const double part = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    const int filled = static_cast<int>(part * kBarWidth);
    text += fmt::format(" [{:#<{}}{:<{}}] {:3.0f} %", "", filled, "", kBarWidth - filled, 100 * part);
  }
  if (done > 0) {
    text += "  " + grouped(done);
    if (total > 0) text += " of " + grouped(total);
    if (elapsed > 0.2) text += fmt::format(", {} a second", shortened(static_cast<double>(done) / elapsed));
  }
  return text + fmt::format("  {:.0f} s", elapsed);
}

}  // namespace voropack::app
