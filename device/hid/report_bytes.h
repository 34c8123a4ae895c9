// Little-endian fields in the bytes of a report, one after the other. The caller has checked the
// length once, so that no access here can leave the report; asserted all the same. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "core/math/assert.h"

namespace hapticd::hid {

/// Takes fields from the front.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  template <typename Field>
  void take(Field& field) noexcept {
    using Unsigned = std::make_unsigned_t<Field>;
    HD_ASSERT(sizeof(Field) <= bytes_.size());
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Field); ++i) {
      value |= std::uint64_t{bytes_[i]} << (8 * i);
    }
    field = static_cast<Field>(static_cast<Unsigned>(value));
    skip(sizeof(Field));
  }
  template <typename Field, std::size_t Count>
  void take(std::array<Field, Count>& fields) noexcept {
    for (Field& field : fields) take(field);
  }
  void skip(std::size_t bytes) noexcept {
    HD_ASSERT(bytes <= bytes_.size());
    bytes_ = bytes_.subspan(bytes);
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// Puts fields at the front; what is never put stays as it is.
class FieldWriter {
 public:
  explicit FieldWriter(std::span<std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  template <typename Field>
  void put(Field field) noexcept {
    HD_ASSERT(sizeof(Field) <= bytes_.size());
    const auto value = static_cast<std::make_unsigned_t<Field>>(field);
    for (std::size_t i = 0; i < sizeof(Field); ++i) {
      bytes_[i] = static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i));
    }
    bytes_ = bytes_.subspan(sizeof(Field));
  }
  template <typename Field, std::size_t Count>
  void put(const std::array<Field, Count>& fields) noexcept {
    for (const Field field : fields) put(field);
  }

 private:
  std::span<std::uint8_t> bytes_;
};

}  // namespace hapticd::hid
