#include "exit_code.h"

#include <fmt/format.h>

#include <filesystem>
#include <new>

#include "version.h"
#include "voropack/error.h"

namespace voropack::app {

namespace {

std::string own_fault(const std::exception& error) {
  return fmt::format("{}\n  This is a fault of voropack {}. Please report it with the command and its input.",
                     error.what(), version());
}

}  // namespace

Failure explain(const std::exception& error) {
  if (dynamic_cast<const Cancelled*>(&error)) return {ExitCode::kInterrupted, "interrupted; nothing was written"};
  if (dynamic_cast<const InputError*>(&error)) return {ExitCode::kInput, error.what()};
  if (dynamic_cast<const OptionError*>(&error)) return {ExitCode::kInput, error.what()};
  if (dynamic_cast<const LimitError*>(&error)) return {ExitCode::kLimit, error.what()};
  if (dynamic_cast<const NumericalError*>(&error)) return {ExitCode::kNotConverged, error.what()};
  if (dynamic_cast<const std::bad_alloc*>(&error))
    return {ExitCode::kLimit,
            "out of memory\n  Fix: ask for fewer vertices (larger --size or --gradation), or give the machine more."};
  if (dynamic_cast<const std::filesystem::filesystem_error*>(&error)) return {ExitCode::kInput, error.what()};
  return {ExitCode::kInternal, own_fault(error)};
}

}  // namespace voropack::app
