// Collects what is wrong with a DomainInput and says it in the input's own numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/place_text.h"
#include "voropack/domain.h"
#include "voropack/error.h"

namespace voropack::domain_impl {

/// Words for elements of an input: "point 4", "segment 3 (points 4, 7)", "facet 12 (line 31)".
template <int D>
class Names {
 public:
  explicit Names(const DomainInput<D>& input) : input_(&input) {}
  [[nodiscard]] std::string point(std::size_t i) const;
  [[nodiscard]] std::string segment(std::size_t i) const;
  [[nodiscard]] std::string facet(std::size_t i) const;
  [[nodiscard]] std::size_t number(std::size_t i) const { return i + input_->first_index; }

 private:
  const DomainInput<D>* input_;
};

/// Up to kMaxFaults faults; more are counted only.
template <int D>
class FaultList {
 public:
  explicit FaultList(const DomainInput<D>& input) : input_(&input) {}

  /// `id` without its "domain." in front.
  void add(const std::string& id, std::string message, std::string fix, const std::optional<Vec<D>>& position = {},
           const std::optional<std::uint64_t>& line = {});
  [[nodiscard]] bool full() const { return faults_.size() >= kMaxFaults; }
  [[nodiscard]] bool empty() const { return faults_.empty(); }
  /// Throws InputError if there is any fault.
  void throw_if_any() const {
    if (!faults_.empty()) throw InputError(faults_);
  }

 private:
  const DomainInput<D>* input_;
  std::vector<Fault> faults_;
};

}  // namespace voropack::domain_impl
