// The closed list of errors that the library throws. Each carries a stable id and, where known, the place.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace voropack {

/// One thing that is wrong with an input: a stable id, what is wrong where, and how to mend it.
struct Fault {
  std::string id{};                       ///< Stable, such as "domain.self_intersection".
  std::string message{};                  ///< What and where, in words, with coordinates and the input's own numbers.
  std::string fix{};                      ///< How to mend it, as an order.
  std::string file{};                     ///< Empty if the input was not read from a file.
  std::optional<std::uint64_t> line{};    ///< 1-based line of `file`.
  std::optional<std::uint64_t> column{};  ///< 1-based column of `line`.
  std::vector<double> position{};         ///< D coordinates, or empty.

  /// `file:line:column: message  [id]` and `  Fix: fix` on a line of its own.
  [[nodiscard]] std::string text() const;
};

class Error : public std::runtime_error {
 public:
  explicit Error(Fault fault) : Error(std::vector<Fault>{std::move(fault)}) {}
  explicit Error(std::vector<Fault> faults);

  /// At least one; at most kMaxFaults are reported together.
  [[nodiscard]] const std::vector<Fault>& faults() const { return faults_; }
  /// The id of the first fault.
  [[nodiscard]] const std::string& id() const { return faults_.front().id; }

 private:
  std::vector<Fault> faults_;
};

inline constexpr std::size_t kMaxFaults = 20;

/// The data is wrong.
class InputError : public Error {
  using Error::Error;
};
/// A setting is wrong.
class OptionError : public Error {
  using Error::Error;
};
/// Memory, count or time does not suffice; found before the work where that is possible.
class LimitError : public Error {
  using Error::Error;
};
/// An iteration did not converge.
class NumericalError : public Error {
  using Error::Error;
};
/// A fault of ours. The message says how to replay it.
class InternalError : public Error {
  using Error::Error;
};
/// The observer asked to stop.
class Cancelled : public Error {
 public:
  Cancelled();
};

}  // namespace voropack
