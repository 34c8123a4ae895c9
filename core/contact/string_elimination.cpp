// See string_elimination.h. RT: yes.
#include "core/contact/string_elimination.h"

namespace hapticd {

ArrowMatrix::ArrowMatrix(std::size_t core_size, std::size_t unknowns) noexcept
    : strings_((unknowns - core_size) / 2) {
  core.size = core_size;
  for (std::size_t i = 0; i < core_size; ++i) {
    for (std::size_t j = 0; j <= i; ++j) core(i, j) = 0.0;
  }
  for (std::size_t k = 0; k < strings_; ++k) {
    for (std::size_t a = 0; a < 2; ++a) {
      for (std::size_t b = 0; b < 2; ++b) blocks_[k].own[a][b] = 0.0;
      for (std::size_t j = 0; j < core_size; ++j) blocks_[k].with_core[a][j] = 0.0;
    }
  }
}

void ArrowMatrix::scale(const std::array<double, kMaxQpUnknowns>& inverse_root) noexcept {
  for (std::size_t i = 0; i < core.size; ++i) {
    for (std::size_t j = 0; j <= i; ++j) core(i, j) *= inverse_root[i] * inverse_root[j];
  }
  for (std::size_t k = 0; k < strings_; ++k) {
    const std::size_t first = core.size + 2 * k;
    for (std::size_t a = 0; a < 2; ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        blocks_[k].own[a][b] *= inverse_root[first + a] * inverse_root[first + b];
      }
      blocks_[k].own[a][a] += 1.0;
      for (std::size_t j = 0; j < core.size; ++j) {
        blocks_[k].with_core[a][j] *= inverse_root[first + a] * inverse_root[j];
      }
    }
  }
}

void ArrowMatrix::eliminate(double least, std::span<EliminatedString> strings) noexcept {
  SquareMatrix own;
  SquareMatrix root;
  own.size = 2;
  for (std::size_t k = 0; k < strings_; ++k) {
    const Block& block = blocks_[k];
    EliminatedString& string = strings[k];
    for (std::size_t a = 0; a < 2; ++a) {
      for (std::size_t b = 0; b <= a; ++b) own(a, b) = block.own[a][b];
    }
    inverse_square_root(own, least, root);
    for (std::size_t a = 0; a < 2; ++a) {
      for (std::size_t b = 0; b < 2; ++b) string.root[a][b] = root(a, b);
    }
    // root' H_sc: its square is what the core loses.
    std::array<std::array<double, kMaxCoreUnknowns>, 2> joined;
    for (std::size_t b = 0; b < 2; ++b) {
      for (std::size_t j = 0; j < core.size; ++j) {
        joined[b][j] = root(0, b) * block.with_core[0][j] + root(1, b) * block.with_core[1][j];
      }
    }
    for (std::size_t j = 0; j < core.size; ++j) {
      for (std::size_t a = 0; a < 2; ++a) {
        string.follow[a][j] = -(root(a, 0) * joined[0][j] + root(a, 1) * joined[1][j]);
      }
      for (std::size_t i = 0; i <= j; ++i) {
        core(j, i) -= joined[0][j] * joined[0][i] + joined[1][j] * joined[1][i];
      }
    }
  }
}

void unscale(const std::array<double, kMaxQpUnknowns>& inverse_root, std::size_t core_size,
             std::span<EliminatedString> strings) noexcept {
  for (std::size_t k = 0; k < strings.size(); ++k) {
    for (std::size_t a = 0; a < 2; ++a) {
      const double unit = inverse_root[core_size + 2 * k + a];
      for (double& entry : strings[k].root[a]) entry *= unit;
      for (std::size_t j = 0; j < core_size; ++j) strings[k].follow[a][j] *= unit / inverse_root[j];
    }
  }
}

}  // namespace hapticd
