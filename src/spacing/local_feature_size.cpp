#include <limits>

#include "spacing/pair_search.h"
#include "voropack/spacing.h"

namespace voropack {

template <int D>
struct LocalFeatureSize<D>::Impl {
  PolytopeSet<D> polytopes;
};

template <int D>
LocalFeatureSize<D>::LocalFeatureSize(const Domain<D>& domain)
    : impl_(std::make_unique<const Impl>(Impl{PolytopeSet<D>(domain)})) {}

template <int D>
LocalFeatureSize<D>::~LocalFeatureSize() = default;
template <int D>
LocalFeatureSize<D>::LocalFeatureSize(LocalFeatureSize&&) noexcept = default;
template <int D>
LocalFeatureSize<D>& LocalFeatureSize<D>::operator=(LocalFeatureSize&&) noexcept = default;

template <int D>
double LocalFeatureSize<D>::operator()(const Vec<D>& x) const {
  return search_pairs<D>(impl_->polytopes, nullptr, {1.0, 0.0}, x, std::numeric_limits<double>::infinity(),
                         std::numeric_limits<std::size_t>::max())
      .value;
}

template class LocalFeatureSize<2>;
template class LocalFeatureSize<3>;

}  // namespace voropack
