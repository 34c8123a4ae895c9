// A secret in memory that the system neither swaps out nor writes into a core dump, and that is
// wiped when the last copy goes: sodium_malloc of libsodium, with its guard pages. Where the limit
// on locked memory is used up it may be swapped out; the rest holds. Not RT.
#pragma once

#include <sodium.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>

namespace hapticd::noise {

/// A value that never changes; copies share it. About four pages of address space, one of memory.
template <typename T>
class Locked {
 public:
  /// All zeros.
  Locked() : Locked(T{}) {}
  /// A copy of `value`, which the caller wipes.
  explicit Locked(const T& value) : value_(room()) {
    ::new (value_.get()) T(value);
    ::sodium_mprotect_readonly(value_.get());
  }
  Locked(const Locked&) = default;
  Locked& operator=(const Locked&) = default;
  ~Locked() = default;

  /// What `fill(T&)` wrote into it, so that it was nowhere else. Throws what `fill` throws, and
  /// std::bad_alloc.
  template <typename Fill>
  [[nodiscard]] static Locked filled(const Fill& fill) {
    Locked made{Room{}};
    fill(*made.value_);
    ::sodium_mprotect_readonly(made.value_.get());
    return made;
  }

  [[nodiscard]] const T& get() const noexcept { return *value_; }

  friend bool operator==(const Locked& a, const Locked& b) noexcept {
    return ::sodium_memcmp(a.value_.get(), b.value_.get(), sizeof(T)) == 0;
  }

 private:
  // It is placed at the end of a page, whatever that is a multiple of.
  static_assert(alignof(T) == 1 && std::is_trivially_copyable_v<T> &&
                std::is_trivially_destructible_v<T>);

  struct Room {};
  explicit Locked(Room /*empty*/) : value_(room()) { ::new (value_.get()) T{}; }

  static std::shared_ptr<T> room() {
    if (::sodium_init() < 0) throw std::runtime_error("libsodium does not start");
    void* bytes = ::sodium_malloc(sizeof(T));
    if (bytes == nullptr) throw std::bad_alloc();
    return {static_cast<T*>(bytes), [](T* value) { ::sodium_free(value); }};
  }

  std::shared_ptr<T> value_;
};

}  // namespace hapticd::noise
