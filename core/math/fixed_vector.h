// A vector of fixed capacity: the container of the realtime path. Never allocates; refuses what
// does not fit and counts it. Elements are constructed once with the container, `clear` does not
// destroy them. RT: yes, O(1) per call.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/math/assert.h"

namespace hapticd {

/// Up to `Capacity` elements of `T`, in order of insertion.
template <typename T, std::size_t Capacity>
class FixedVector {
 public:
  /// Appends; false, and counted in overflow(), when full.
  bool push_back(const T& value) noexcept {
    if (size_ == Capacity) {
      ++overflow_;
      return false;
    }
    items_[size_++] = value;
    return true;
  }
  /// Appends an element to be written in place; null, and counted in overflow(), when full.
  [[nodiscard]] T* append() noexcept {
    if (size_ == Capacity) {
      ++overflow_;
      return nullptr;
    }
    return &items_[size_++];
  }
  /// Empties the vector and its overflow count.
  void clear() noexcept {
    size_ = 0;
    overflow_ = 0;
  }
  /// Drops elements beyond `size` <= size().
  void truncate(std::size_t size) noexcept {
    HD_ASSERT(size <= size_);
    size_ = size;
  }
  /// Elements refused since the last clear().
  [[nodiscard]] std::uint64_t overflow() const noexcept { return overflow_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] bool full() const noexcept { return size_ == Capacity; }
  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }
  [[nodiscard]] T& operator[](std::size_t i) noexcept {
    HD_ASSERT(i < size_);
    return items_[i];
  }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept {
    HD_ASSERT(i < size_);
    return items_[i];
  }
  [[nodiscard]] T* begin() noexcept { return items_.data(); }
  [[nodiscard]] T* end() noexcept { return items_.data() + size_; }
  [[nodiscard]] const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] const T* end() const noexcept { return items_.data() + size_; }

 private:
  std::size_t size_ = 0;
  std::uint64_t overflow_ = 0;
  std::array<T, Capacity> items_;
};

}  // namespace hapticd
