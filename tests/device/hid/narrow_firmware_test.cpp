// The reference firmware with numbers of 2 to 5 bits, on all inputs there are, or an even share of
// them; see narrow_number.h. Truth: of a matrix, the signs of its characteristic polynomial, which
// has real roots alone; of a root, counting; of a shortened wrench, long double. Nothing may
// overflow: what the comments in device_force.c allow for 16, 32 and 64 bits holds in proportion.
#include "tests/device/hid/narrow_firmware.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Entry = Narrow<kBits, true>;
using Gain = Narrow<kBits, false>;
using Word = Narrow<4 * kBits, true>;
using Three = std::array<std::int64_t, 3>;

/// What PROFILE.md adds to the diagonal, N/m.
constexpr int kRounding = 2;

struct Matrix {
  std::int64_t xx, yy, zz, xy, xz, yz;
};

/// Whether no eigenvalue is below zero: of (t - a)(t - b)(t - c) with real a, b and c no sign is
/// against it.
bool is_semidefinite(const Matrix& m) {
  const std::int64_t sum = m.xx + m.yy + m.zz;
  const std::int64_t pairs =
      m.xx * m.yy + m.yy * m.zz + m.zz * m.xx - m.xy * m.xy - m.xz * m.xz - m.yz * m.yz;
  const std::int64_t all = m.xx * m.yy * m.zz + 2 * m.xy * m.yz * m.xz - m.xx * m.yz * m.yz -
                           m.yy * m.xz * m.xz - m.zz * m.xy * m.xy;
  return sum >= 0 && pairs >= 0 && all >= 0;
}

std::int64_t row_bound(const Matrix& m) {
  const std::int64_t xy = std::abs(m.xy);
  const std::int64_t xz = std::abs(m.xz);
  const std::int64_t yz = std::abs(m.yz);
  return std::max({m.xx + xy + xz, xy + m.yy + yz, xz + yz + m.zz});
}

/// Tries a K, with a limit of its rows at, above and below their bound.
struct Judge {
  narrow::HapDevice device{};
  narrow::HapAffine affine{};
  std::int64_t tried = 0, taken = 0, wrong = 0;

  void look(const Matrix& m) {
    const std::array<std::int64_t, 6> entries{m.xx, m.yy, m.zz, m.xy, m.xz, m.yz};
    for (std::size_t i = 0; i < 6; ++i) affine.k_npm[i].value = entries[i];
    const bool good =
        std::min({m.xx, m.yy, m.zz}) >= 0 &&
        is_semidefinite({m.xx + kRounding, m.yy + kRounding, m.zz + kRounding, m.xy, m.xz, m.yz});
    const std::int64_t bound = std::max<std::int64_t>(row_bound(m), 0);
    device.settings.affine_k_max_npm = static_cast<std::uint32_t>(bound);
    const bool took = narrow::hap_affine_is_sound(&device, &affine);
    ++tried;
    taken += took ? 1 : 0;
    wrong += took == good ? 0 : 1;
    if (!took || bound == 0) return;
    device.settings.affine_k_max_npm = static_cast<std::uint32_t>(bound - 1);
    wrong += narrow::hap_affine_is_sound(&device, &affine) ? 1 : 0;
  }
  void look_beside(std::int64_t xx, std::int64_t yy, std::int64_t zz) {
    for (std::int64_t xy = Entry::kLeast; xy <= Entry::kMost; ++xy) {
      for (std::int64_t xz = Entry::kLeast; xz <= Entry::kMost; ++xz) {
        for (std::int64_t yz = Entry::kLeast; yz <= Entry::kMost; ++yz)
          look({xx, yy, zz, xy, xz, yz});
      }
    }
  }
};

TEST_CASE(
    "of all K of few bits those are taken that push along no way, up to the limit of their rows") {
  // 5 bits have 2^30 matrices: of their diagonals an even share is tried, or all.
  const std::int64_t share = kBits > 4 ? scaled(1000) : 1000;
  Judge judge;
  narrow_overflows = 0;
  std::int64_t diagonal = 0;
  for (std::int64_t xx = Entry::kLeast; xx <= Entry::kMost; ++xx) {
    for (std::int64_t yy = Entry::kLeast; yy <= Entry::kMost; ++yy) {
      for (std::int64_t zz = Entry::kLeast; zz <= Entry::kMost; ++zz) {
        // 619 is a prime: neighbours are not left out together.
        if (diagonal++ * 619 % 1000 < share) judge.look_beside(xx, yy, zz);
      }
    }
  }
  CHECK(judge.wrong == 0);
  CHECK(judge.taken > 0);
  CHECK(judge.taken < judge.tried);
  CHECK(narrow_overflows == 0);
  if (share == 1000) CHECK(judge.tried == std::int64_t{1} << (6 * kBits));
  MESSAGE(judge.tried << " matrices of " << kBits << " bits, " << judge.taken << " taken");
}

TEST_CASE("every gain is taken up to every limit") {
  narrow::HapDevice device{};
  std::int64_t wrong = 0;
  for (std::int64_t most = 0; most <= Gain::kMost; ++most) {
    device.settings.affine_b_max_mnspm.value = device.settings.affine_kr_max_mnmprad.value = most;
    device.settings.affine_br_max_10unmsprad.value = most;
    for (std::int64_t gain = 0; gain <= Gain::kMost; ++gain) {
      for (std::size_t which = 0; which < 9; ++which) {
        narrow::HapAffine affine{};
        (which < 3   ? affine.b_mnspm
         : which < 6 ? affine.kr_mnmprad
                     : affine.br_10unmsprad)[which % 3]
            .value = gain;
        wrong += narrow::hap_affine_is_sound(&device, &affine) == (gain <= most) ? 0 : 1;
      }
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("every whole number of a word has its root, rounded up") {
  narrow_overflows = 0;
  std::int64_t wrong = 0;
  std::int64_t root = 0;
  for (std::int64_t square = 0; square <= Narrow<4 * kBits, false>::kMost; ++square) {
    while (root * root < square) ++root;
    wrong += narrow::root_up(Narrow<4 * kBits, false>::of(square)).value == root ? 0 : 1;
  }
  CHECK(wrong == 0);
  CHECK(narrow_overflows == 0);
}

/// Whether `after` is what PROFILE.md, section 8, asks of `v` shortened to `most`.
bool is_shortened(const Three& v, const Three& after, std::int64_t most, bool cut) {
  std::int64_t square = 0;
  std::int64_t left = 0;
  bool short_enough = true;
  for (std::size_t i = 0; i < 3; ++i) {
    square += v[i] * v[i];
    left += after[i] * after[i];
    short_enough = short_enough && std::abs(v[i]) <= NarrowInt::kMost;
  }
  if (square <= most * most) return !cut && after == v;
  if (!cut || left > most * most) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const long double ideal =
        static_cast<long double>(v[i] * most) / std::sqrt(static_cast<long double>(square));
    const long double error = std::abs(ideal - static_cast<long double>(after[i]));
    // The root is less than 1 too long and the quotient loses less than 1; halving loses more.
    if (after[i] * v[i] < 0 || std::abs(after[i]) > std::abs(v[i]) ||
        (short_enough && error >= 2.0L))
      return false;
  }
  return true;
}

TEST_CASE("every wrench is shortened to every limit along itself, and left alone within it") {
  // All that clamp is made for with words of 8 bits; with longer ones, all wrenches of an int.
  const std::int64_t reach =
      kBits == 2 ? (std::int64_t{1} << (4 * kBits - 2)) - 1 : NarrowInt::kMost + 1;
  const std::int64_t most_most = (std::int64_t{1} << (2 * kBits - 2)) - 1;
  const std::int64_t share = kBits > 3 ? std::max<std::int64_t>(scaled(1000) / 10, 1) : 1000;
  narrow_overflows = 0;
  std::int64_t tried = 0;
  std::int64_t wrong = 0;
  if (kBits > 4) return;
  for (std::int64_t x = -reach; x <= reach; ++x) {
    for (std::int64_t y = -reach; y <= reach; ++y) {
      for (std::int64_t z = -reach; z <= reach; ++z) {
        if (share < 1000 && (x * 7 + y * 619 + z * 31 + (1 << 20)) % 1000 >= share) continue;
        for (std::int64_t most = 0; most <= most_most; ++most) {
          Word v[3] = {Word::of(x), Word::of(y), Word::of(z)};
          const bool cut = narrow::clamp(v, Word::of(most));
          wrong += is_shortened({x, y, z}, {v[0].value, v[1].value, v[2].value}, most, cut) ? 0 : 1;
          ++tried;
        }
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(narrow_overflows == 0);
  MESSAGE(tried << " wrenches and limits, words of " << 4 * kBits << " bits");
}

}  // namespace
}  // namespace hapticd::test
