// State that goes from tick to tick as plain numbers: every struct of it has one function
// visit_fields(state, visit) that names each field once, and what visits decides what is done with
// them: written down, or read back. The functions take their struct apart by structured binding, so
// that a field that is added without being visited does not compile. Numbers keep their bits. RT:
// yes, about 1 ns per field.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "core/math/fixed_vector.h"
#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"

namespace hapticd {

/// `T`, const or not: what a visit_fields function takes.
template <typename State, typename T>
concept FieldsOf = std::same_as<std::remove_const_t<State>, T>;

/// Numbers of a state, in the order of their visit.
struct StateNumbers {
  std::span<double> reals;
  std::span<std::int64_t> integers;
};

/// visit_fields() of a struct of which every field is visited as it is: all of them, in order.
#define HD_VISIT_FIELDS(Type, ...)                                     \
  template <FieldsOf<Type> State, typename Visit>                      \
  HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept { \
    auto& [__VA_ARGS__] = state;                                       \
    visit(__VA_ARGS__);                                                \
  }

HD_VISIT_FIELDS(Pose, q, p)
HD_VISIT_FIELDS(Twist, v, w)
HD_VISIT_FIELDS(Wrench, f, t)

/// Writes what it visits into `room`, as long as it fits.
class StateWriter {
 public:
  explicit StateWriter(const StateNumbers& room) noexcept : room_(room) {}

  /// Visits fields in order: numbers, choices, vectors of core/math, and whatever has visit_fields.
  template <typename... Fields>
  HD_REALTIME void operator()(const Fields&... fields) noexcept {
    (one(fields), ...);
  }
  /// A whole number or choice with its range.
  template <typename Field>
  HD_REALTIME void bounded(const Field& field, std::int64_t /*low*/,
                           std::int64_t /*high*/) noexcept {
    integer(static_cast<std::int64_t>(field));
  }
  /// The first `count` elements of an array whose count has been visited before.
  template <typename T, std::size_t N, typename Count>
  HD_REALTIME void first(const std::array<T, N>& items, Count count) noexcept {
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) one(items[k]);
  }

  /// False once something did not fit; what is written is useless then.
  [[nodiscard]] bool good() const noexcept { return good_; }
  [[nodiscard]] std::size_t reals() const noexcept { return reals_; }
  [[nodiscard]] std::size_t integers() const noexcept { return integers_; }

 private:
  void real(double value) noexcept {
    good_ = good_ && reals_ < room_.reals.size();
    if (good_) room_.reals[reals_++] = value;
  }
  void integer(std::int64_t value) noexcept {
    good_ = good_ && integers_ < room_.integers.size();
    if (good_) room_.integers[integers_++] = value;
  }
  template <typename T, std::size_t N>
  void one(const FixedVector<T, N>& items) noexcept {
    integer(static_cast<std::int64_t>(items.size()));
    for (const T& item : items) one(item);
  }
  template <typename T, std::size_t N>
  void one(const std::array<T, N>& items) noexcept {
    for (const T& item : items) one(item);
  }
  void one(const Vector3& v) noexcept {
    for (int k = 0; k < 3; ++k) real(v[k]);
  }
  void one(const Quaternion& q) noexcept {
    for (const double number : to_array(q)) real(number);
  }
  template <typename Field>
  void one(const Field& field) noexcept {
    if constexpr (std::floating_point<Field>) {
      real(static_cast<double>(field));
    } else if constexpr (std::integral<Field>) {
      integer(static_cast<std::int64_t>(field));
    } else {
      static_assert(!std::is_enum_v<Field>, "a choice has a range: bounded()");
      visit_fields(field, *this);
    }
  }

  StateNumbers room_;
  std::size_t reals_ = 0;
  std::size_t integers_ = 0;
  bool good_ = true;
};

/// Furthest instant, and longest time, that is read back, ns: 146 years. The sum and the difference
/// of two are still numbers.
inline constexpr std::int64_t kMax_ns = std::int64_t{1} << 62U;

/// Reads back what a StateWriter wrote. Numbers are not trusted: counts, choices, instants and
/// whole numbers out of their range end it, and nothing more is changed.
class StateReader {
 public:
  StateReader(std::span<const double> reals, std::span<const std::int64_t> integers) noexcept
      : reals_(reals), integers_(integers) {}

  template <typename... Fields>
  void operator()(Fields&... fields) noexcept {
    (one(fields), ...);
  }
  template <typename Field>
  void bounded(Field& field, std::int64_t low, std::int64_t high) noexcept {
    const std::int64_t value = integer();
    good_ = good_ && value >= low && value <= high;
    if (good_) field = static_cast<Field>(value);
  }
  template <typename T, std::size_t N, typename Count>
  void first(std::array<T, N>& items, Count count) noexcept {
    good_ = good_ && static_cast<std::size_t>(count) <= N;
    for (std::size_t k = 0; good_ && k < static_cast<std::size_t>(count); ++k) one(items[k]);
  }

  /// Something was missing or out of range.
  void fail() noexcept { good_ = false; }
  [[nodiscard]] bool good() const noexcept { return good_; }
  /// Everything was read, and all of it was good.
  [[nodiscard]] bool complete() const noexcept {
    return good_ && next_real_ == reals_.size() && next_integer_ == integers_.size();
  }

 private:
  double real() noexcept {
    good_ = good_ && next_real_ < reals_.size();
    return good_ ? reals_[next_real_++] : 0.0;
  }
  std::int64_t integer() noexcept {
    good_ = good_ && next_integer_ < integers_.size();
    return good_ ? integers_[next_integer_++] : 0;
  }
  template <typename T, std::size_t N>
  void one(FixedVector<T, N>& items) noexcept {
    const std::int64_t size = integer();
    good_ = good_ && size >= 0 && size <= static_cast<std::int64_t>(N);
    if (!good_) return;
    items.clear();
    for (std::int64_t k = 0; good_ && k < size; ++k) {
      T item{};
      one(item);
      items.push_back(item);
    }
  }
  template <typename T, std::size_t N>
  void one(std::array<T, N>& items) noexcept {
    for (T& item : items) one(item);
  }
  void one(Vector3& v) noexcept {
    for (int k = 0; k < 3; ++k) {
      const double number = real();
      if (good_) v[k] = number;
    }
  }
  void one(Quaternion& q) noexcept {
    Array4 numbers{};
    one(numbers);
    if (good_) q = to_quaternion(numbers);
  }
  template <typename Field>
  void one(Field& field) noexcept {
    if constexpr (std::floating_point<Field>) {
      const double number = real();
      if (good_) field = static_cast<Field>(number);
    } else if constexpr (std::same_as<Field, std::uint64_t>) {
      const std::int64_t bits = integer();
      if (good_) field = static_cast<std::uint64_t>(bits);
    } else if constexpr (std::same_as<Field, std::int64_t>) {
      bounded(field, 1 - kMax_ns, kMax_ns - 1);
    } else if constexpr (std::same_as<Field, bool>) {
      bounded(field, 0, 1);
    } else if constexpr (std::integral<Field>) {
      bounded(field, std::int64_t{std::numeric_limits<Field>::min()},
              std::int64_t{std::numeric_limits<Field>::max()});
    } else {
      visit_fields(field, *this);
    }
  }

  std::span<const double> reals_;
  std::span<const std::int64_t> integers_;
  std::size_t next_real_ = 0;
  std::size_t next_integer_ = 0;
  bool good_ = true;
};

/// FNV-1a over 64-bit words, to be carried on from word to word.
inline constexpr std::uint64_t kStateHashStart = 14695981039346656037ULL;
[[nodiscard]] HD_REALTIME constexpr std::uint64_t hashed(std::uint64_t hash,
                                                         std::uint64_t word) noexcept {
  return (hash ^ word) * 1099511628211ULL;
}

/// The bits of every number, reals first, carried on from `hash`. 1 ns per number.
[[nodiscard]] HD_REALTIME inline std::uint64_t hash_numbers(
    std::uint64_t hash, std::span<const double> reals,
    std::span<const std::int64_t> integers) noexcept {
  for (const double number : reals) hash = hashed(hash, std::bit_cast<std::uint64_t>(number));
  for (const std::int64_t number : integers) {
    hash = hashed(hash, static_cast<std::uint64_t>(number));
  }
  return hash;
}

}  // namespace hapticd
