// An array that is not set when it is made: the parallel loop that fills it is the first to touch its memory.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace voropack {

template <class T>
class RawArray {
 public:
  RawArray() = default;
  explicit RawArray(std::size_t n) : size_(n), values_(std::make_unique_for_overwrite<T[]>(n)) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  T* data() { return values_.get(); }
  const T* data() const { return values_.get(); }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  operator std::span<T>() { return {values_.get(), size_}; }
  operator std::span<const T>() const { return {values_.get(), size_}; }

 private:
  std::size_t size_ = 0;
  std::unique_ptr<T[]> values_;
};

}  // namespace voropack
