// See sagging_cable.h.
#include "core/scene/sagging_cable.h"

#include <cmath>

namespace hapticd {
namespace {

/// Point of the parabola at lambda.
Array3 point_at(const StringDescription& string, double lambda) noexcept {
  const Array3& a = string.parameters.p_WA;
  const Array3& b = string.parameters.p_WB;
  Array3 p{};
  for (std::size_t k = 0; k < 3; ++k) p[k] = a[k] + lambda * (b[k] - a[k]);
  p[1] -= 4.0 * string.sag * lambda * (1.0 - lambda);
  return p;
}

double distance(const Array3& a, const Array3& b) noexcept {
  return (to_vector(b) - to_vector(a)).norm();
}

}  // namespace

int cable_pieces(double sag) noexcept {
  if (!(sag > 0.0)) return 1;
  return sag <= kSlightSag ? 3 : kMaxCablePieces;
}

// The sagitta of a parabola over an n-th of its span is sag / n^2.
double cable_error(double sag) noexcept {
  const auto pieces = static_cast<double>(cable_pieces(sag));
  return sag > 0.0 ? sag / (pieces * pieces) : 0.0;
}

std::vector<StringParameters> cable_of(const StringDescription& string) {
  const int count = cable_pieces(string.sag);
  if (count == 1) return {string.parameters};
  const double span = distance(string.parameters.p_WA, string.parameters.p_WB);
  std::vector<StringParameters> pieces(static_cast<std::size_t>(count), string.parameters);
  for (int i = 0; i < count; ++i) {
    StringParameters& piece = pieces[static_cast<std::size_t>(i)];
    piece.p_WA = point_at(string, static_cast<double>(i) / count);
    piece.p_WB = point_at(string, static_cast<double>(i + 1) / count);
    // A string yields at lambda by force T delta / (c L) + E A delta^3 / (2 c^2 L^3) with
    // c = lambda (1 - lambda); for the middle of the piece alone c is 1/4.
    const double lambda = (i + 0.5) / count;
    const double c = lambda * (1.0 - lambda);
    const double share = distance(piece.p_WA, piece.p_WB) / span;
    const double stiffer = share * share * share / (16.0 * c * c);
    piece.tension *= share / (4.0 * c);
    piece.youngs_modulus *= stiffer;
    if (piece.axial_stiffness != kNoAxialStiffness) piece.axial_stiffness *= stiffer;
  }
  return pieces;
}

}  // namespace hapticd
