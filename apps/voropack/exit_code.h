// How the program ends: one number per kind of end, and the words for it.
#pragma once

#include <exception>
#include <string>

namespace voropack::app {

enum class ExitCode : int {
  kDone = 0,
  kCheckFailed = 1,   ///< The certificate or a check failed.
  kInput = 2,         ///< Bad input, option or place to write to.
  kLimit = 3,         ///< Vertices, memory or time.
  kNotConverged = 4,  ///< No convergence.
  kInternal = 70,     ///< A fault of ours.
  kInterrupted = 130,
};

struct Failure {
  ExitCode code;
  std::string message;
};

/// The exit code and the message for an exception that ended a command.
Failure explain(const std::exception& error);

}  // namespace voropack::app
