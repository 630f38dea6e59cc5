// An array whose elements are not set when it is made.
#pragma once

#include <cstddef>
#include <memory>

namespace voropack {

/// For large arrays that a parallel loop fills: a vector would be set to zero by one thread before. `Index` is an id.
template <class Index, class T>
class UnsetArray {
 public:
  explicit UnsetArray(std::size_t n) : values_(std::make_unique_for_overwrite<T[]>(n)) {}

  T& operator[](Index i) { return values_[i.value()]; }
  const T& operator[](Index i) const { return values_[i.value()]; }

 private:
  std::unique_ptr<T[]> values_;
};

}  // namespace voropack
