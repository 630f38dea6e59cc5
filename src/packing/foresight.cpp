#include "packing/foresight.h"

namespace voropack {

template <int D>
Spacing<D> with_foreseen_caps(const Domain<D>&, const Spacing<D>& spacing) {
  return spacing;
}

template Spacing<2> with_foreseen_caps(const Domain<2>&, const Spacing<2>&);
template Spacing<3> with_foreseen_caps(const Domain<3>&, const Spacing<3>&);

}  // namespace voropack
