// A hash that nobody without its secret can foresee: SipHash-2-4 of libsodium, for tables that
// strangers fill. J.-P. Aumasson, D. J. Bernstein, "SipHash: a fast short-input PRF", 2012. Pure.
// No heap. Not RT.
#pragma once

#include <sodium.h>

#include <array>
#include <cstdint>
#include <span>

namespace hapticd {

class SecretHash {
 public:
  using Secret = std::array<std::uint8_t, crypto_shorthash_KEYBYTES>;

  explicit SecretHash(const Secret& secret) : secret_(secret) {}

  /// 64 bits of any bytes, about 1 ns each.
  [[nodiscard]] std::uint64_t operator()(std::span<const std::uint8_t> bytes) const noexcept {
    std::array<std::uint8_t, crypto_shorthash_BYTES> hash{};
    crypto_shorthash(hash.data(), bytes.data(), bytes.size(), secret_.data());
    std::uint64_t number = 0;
    for (const std::uint8_t byte : hash) number = number << 8U | byte;
    return number;
  }

 private:
  Secret secret_;
};

}  // namespace hapticd
