// Stops a packing before it needs more vertices or memory than there may be.
#pragma once

#include <optional>

#include "voropack/packing.h"

namespace voropack {

/// What is known of the number of vertices to come, kept up to date while repairs shrink f.
template <int D>
class Budget {
 public:
  Budget(const Domain<D>& domain, const PackingOptions& options) : domain_(domain), options_(options) {}

  /// Throws LimitError if f asks for too many vertices.
  void check_ahead(const Spacing<D>& f);
  /// The same when f may have shrunk and there are `n_boundary` spheres on the boundary. The estimate costs as much as
  /// a small mesh, so it is made only if the limit may be within reach.
  void check_again(const Spacing<D>& f, std::size_t n_boundary);
  /// CountEstimate::plateau of f as it was ahead.
  [[nodiscard]] std::optional<double> plateau() const { return plateau_; }

 private:
  [[noreturn]] void refuse(const Spacing<D>& f, double estimate) const;
  [[nodiscard]] double affordable() const;

  const Domain<D>& domain_;
  const PackingOptions& options_;
  double estimate_ = 0;
  std::optional<double> plateau_;
};

}  // namespace voropack
