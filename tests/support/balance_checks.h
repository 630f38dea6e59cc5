// Conservation, as tests of solvers check it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "voropack/diffusion.h"

namespace voropack::test {

inline constexpr double kBalance = 1e-12;  ///< Relative to what flows.

/// Every region is in balance, and what regions exchange adds up to nothing.
inline void expect_balanced(const std::vector<RegionBalance>& balances) {
  double exchange = 0, throughput = 0;
  for (const RegionBalance& balance : balances) {
    EXPECT_LE(std::abs(balance.imbalance), kBalance * balance.throughput) << "region " << balance.region;
    exchange += balance.interface_inflow;
    throughput += balance.throughput;
  }
  EXPECT_LE(std::abs(exchange), kBalance * throughput);
}

}  // namespace voropack::test
