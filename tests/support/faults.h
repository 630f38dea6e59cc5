// The fault that something throws.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "voropack/error.h"

namespace voropack::test {

/// Runs fn, which has to throw an Error of class E, and returns its first fault.
template <class E, class Fn>
Fault fault_of(Fn&& fn) {
  try {
    std::forward<Fn>(fn)();
  } catch (const E& error) {
    return error.faults().front();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace voropack::test
