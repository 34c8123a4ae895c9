// A whole number of a few bits, to compile the reference firmware with in place of int16_t and its
// kin, so that all inputs of a function can be tried. It behaves as C's types do, but for one
// thing: a result that does not fit is kept and counted, of unsigned types too. A word is 4 * kBits
// wide, an int half of it, a short a quarter: as 64, 32 and 16.
#pragma once

#include <compare>
#include <cstdint>
#include <type_traits>

namespace hapticd::test {

/// Of the short, in this program.
constexpr int kBits = HAPTICD_NARROW_BITS;

/// Results that did not fit, in this program.
inline std::int64_t narrow_overflows = 0;

template <int Bits, bool Signed>
struct Narrow {
  static constexpr int kWidth = Bits;
  static constexpr bool kSigned = Signed;
  static constexpr std::int64_t kLeast = Signed ? -(std::int64_t{1} << (Bits - 1)) : 0;
  static constexpr std::int64_t kMost = (std::int64_t{1} << (Signed ? Bits - 1 : Bits)) - 1;

  std::int64_t value;

  Narrow() = default;
  /// Implicit, as between C's types.
  Narrow(int number) : value(checked(number)) {}
  template <int Other, bool OtherSigned>
  Narrow(Narrow<Other, OtherSigned> number) : value(checked(number.value)) {}
  explicit operator std::uint32_t() const { return static_cast<std::uint32_t>(value); }

  static Narrow of(std::int64_t number) {
    Narrow made;
    made.value = checked(number);
    return made;
  }
  static std::int64_t checked(std::int64_t number) {
    narrow_overflows += number < kLeast || number > kMost ? 1 : 0;
    return number;
  }

  template <typename Other>
  Narrow& operator+=(Other other) {
    return *this = *this + other;
  }
  template <typename Other>
  Narrow& operator-=(Other other) {
    return *this = *this - other;
  }
  template <typename Other>
  Narrow& operator/=(Other other) {
    return *this = *this / other;
  }
  Narrow& operator>>=(int count) { return *this = *this >> count; }
};

/// An int or a constant of an enum, among narrow numbers.
using NarrowInt = Narrow<2 * kBits, true>;

template <typename T>
struct NarrowOf {
  using Type = std::conditional_t<std::is_same_v<T, int> || std::is_enum_v<T>, NarrowInt, void>;
  static std::int64_t raw(T number) { return static_cast<std::int64_t>(number); }
};
template <int Bits, bool Signed>
struct NarrowOf<Narrow<Bits, Signed>> {
  /// What is shorter than an int becomes one.
  using Type = std::conditional_t<(Bits < NarrowInt::kWidth), NarrowInt, Narrow<Bits, Signed>>;
  static std::int64_t raw(Narrow<Bits, Signed> number) { return number.value; }
};

/// The wider type; of two as wide, the unsigned one.
template <typename A, typename B, typename X = typename NarrowOf<A>::Type,
          typename Y = typename NarrowOf<B>::Type>
using NarrowResult = std::conditional_t<
    (X::kWidth > Y::kWidth), X,
    std::conditional_t<(Y::kWidth > X::kWidth), Y, std::conditional_t<X::kSigned, Y, X>>>;

template <typename T>
std::int64_t raw(T number) {
  return NarrowOf<T>::raw(number);
}

template <typename A, typename B, typename R = NarrowResult<A, B>>
R operator+(A a, B b) {
  return R::of(raw(a) + raw(b));
}
template <typename A, typename B, typename R = NarrowResult<A, B>>
R operator-(A a, B b) {
  return R::of(raw(a) - raw(b));
}
template <typename A, typename B, typename R = NarrowResult<A, B>>
R operator*(A a, B b) {
  return R::of(raw(a) * raw(b));
}
template <typename A, typename B, typename R = NarrowResult<A, B>>
R operator/(A a, B b) {
  return R::of(raw(a) / raw(b));
}
template <typename A, typename B, typename R = NarrowResult<A, B>>
R operator|(A a, B b) {
  return R::of(raw(a) | raw(b));
}
template <typename A, typename B, typename R = NarrowResult<A, B>>
R operator&(A a, B b) {
  return R::of(raw(a) & raw(b));
}
template <int Bits, bool Signed>
auto operator>>(Narrow<Bits, Signed> a, int count) {
  return NarrowOf<Narrow<Bits, Signed>>::Type::of(a.value >> count);
}
template <int Bits, bool Signed>
auto operator<<(Narrow<Bits, Signed> a, int count) {
  return NarrowOf<Narrow<Bits, Signed>>::Type::of(a.value << count);
}
template <int Bits, bool Signed>
auto operator-(Narrow<Bits, Signed> a) {
  return NarrowOf<Narrow<Bits, Signed>>::Type::of(-a.value);
}
template <typename A, typename B, typename = NarrowResult<A, B>>
bool operator==(A a, B b) {
  return raw(a) == raw(b);
}
template <typename A, typename B, typename = NarrowResult<A, B>>
std::strong_ordering operator<=>(A a, B b) {
  return raw(a) <=> raw(b);
}

}  // namespace hapticd::test
