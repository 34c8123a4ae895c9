// The second derivatives of a linearisation where many strings yield. A string meets the tool alone
// and no other string, so that H has the shape of an arrow: the core (tool and soft parts), a block
// of two unknowns for every string, and what joins each block to the core. In
//   y_string = root z_string + follow y_core,   root root' = H_ss^-1,   follow = -H_ss^-1 H_sc,
// the strings are gone from the energy: what is left is the core with S = H_cc - sum H_cs H_ss^-1
// H_sc, the Schur complement. Exact, and linear in the strings. RT: yes, 0.1 us per string.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/math/limits.h"
#include "core/math/realtime.h"
#include "core/math/symmetric_matrix.h"

namespace hapticd {

/// How a string moves with the core, and by itself.
struct EliminatedString {
  std::array<std::array<double, 2>, 2> root;
  std::array<std::array<double, kMaxCoreUnknowns>, 2> follow;
};

/// Lower triangle of H. Unknowns in order: the core, then two of each string that is eliminated;
/// where none is, all are core.
class ArrowMatrix {
 public:
  /// Zeros.
  ArrowMatrix(std::size_t core_size, std::size_t unknowns) noexcept;

  /// Entry of row `i` >= column `j`; both of the same string, or `j` of the core.
  [[nodiscard]] double& operator()(std::size_t i, std::size_t j) noexcept {
    if (i < core.size) return core(i, j);
    Block& block = blocks_[(i - core.size) / 2];
    const std::size_t row = (i - core.size) % 2;
    return j < core.size ? block.with_core[row][j] : block.own[row][(j - core.size) % 2];
  }

  /// Turns H into inverse_root H inverse_root, and adds 1 on the diagonal of the strings.
  HD_REALTIME void scale(const std::array<double, kMaxQpUnknowns>& inverse_root) noexcept;

  /// Takes the strings out of the core. Blocks that are not safely positive definite count with the
  /// magnitudes of their eigenvalues, at least `least` > 0.
  HD_REALTIME void eliminate(double least, std::span<EliminatedString> strings) noexcept;

  [[nodiscard]] std::size_t strings() const noexcept { return strings_; }

  SquareMatrix core;

 private:
  struct Block {
    std::array<std::array<double, 2>, 2> own;
    std::array<std::array<double, kMaxCoreUnknowns>, 2> with_core;
  };

  std::size_t strings_;
  std::array<Block, kMaxDeflectingStrings> blocks_;
};

/// Brings what was found of the scaled matrix back to the units of the unknowns.
HD_REALTIME void unscale(const std::array<double, kMaxQpUnknowns>& inverse_root,
                         std::size_t core_size, std::span<EliminatedString> strings) noexcept;

}  // namespace hapticd
