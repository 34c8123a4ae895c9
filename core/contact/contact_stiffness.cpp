// With y = W^-1/2 z, W the stiffnesses of all unknowns, the rows that bear force span the
// directions of z in which nothing moves; K is G times the projection on them. See
// contact_stiffness.h. RT: yes.
#include "core/contact/contact_stiffness.h"

#include <cmath>

#include "core/contact/coupling_axes.h"

namespace hapticd {
namespace {

/// A row whose part across the rows before it is a smaller share than this says nothing new.
constexpr double kDependent = 1e-6;

/// W^-1/2 of all unknowns; of rotation 1 where its axes differ, whose units are a matrix.
Unknowns inverse_roots(const ContactView& view) noexcept {
  UnknownScale scale{};
  const CouplingStiffness& stiffness = view.input.stiffness;
  const double along = 1.0 / std::sqrt(stiffness.kt);
  const double about = stiffness.per_axis ? 1.0 : 1.0 / std::sqrt(stiffness.kr());
  for (std::size_t i = 0; i < 3; ++i) {
    scale.inverse_root[i] = along;
    scale.inverse_root[i + 3] = about;
    if (!stiffness.per_axis) continue;
    scale.inverse_root[i] /= std::sqrt(stiffness.shares.along_W[static_cast<Eigen::Index>(i)]);
  }
  view.strings.measure(view.state, scale);
  view.parts.measure(view.state, scale);
  return scale.inverse_root;
}

/// The row in z.
Unknowns scaled_row(const ContactRow& row, const Unknowns& root) noexcept {
  Unknowns a{};
  const auto put = [&](std::size_t k, double value) { a[k] = value * root[k]; };
  for (std::size_t i = 0; i < 3; ++i) {
    put(i, row.linear[static_cast<Eigen::Index>(i)]);
    put(i + 3, row.angular[static_cast<Eigen::Index>(i)]);
  }
  if (row.unknown >= 0) {
    const auto u = static_cast<std::size_t>(row.unknown);
    put(u, row.radial);
    put(u + 1, row.tangential);
  }
  for (std::size_t p = 0; p < row.parts; ++p) {
    for (std::size_t i = 0; i < 3; ++i) {
      put(row.part[p].unknown + i, row.part[p].linear[static_cast<Eigen::Index>(i)]);
    }
  }
  return a;
}

double dot(const Unknowns& a, const Unknowns& b, std::size_t unknowns) noexcept {
  double sum = 0.0;
  for (std::size_t k = 0; k < unknowns; ++k) sum += a[k] * b[k];
  return sum;
}

/// Directions of z that the rows so far span, each of unit length across the others.
struct Span {
  std::array<Unknowns, kMaxQpUnknowns> q;
  std::size_t count = 0;

  /// Twice is enough (active_factor.h).
  void add(Unknowns a, std::size_t unknowns) noexcept {
    const double length = std::sqrt(dot(a, a, unknowns));
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t j = 0; j < count; ++j) {
        const double along = dot(a, q[j], unknowns);
        for (std::size_t k = 0; k < unknowns; ++k) a[k] -= along * q[j][k];
      }
    }
    const double rest = std::sqrt(dot(a, a, unknowns));
    if (!(rest > kDependent * length) || count == q.size()) return;
    for (std::size_t k = 0; k < unknowns; ++k) q[count][k] = a[k] / rest;
    ++count;
  }
};

}  // namespace

ContactStiffness contact_stiffness(const ContactView& view, std::size_t unknowns) noexcept {
  ContactStiffness stiffness;
  if (view.result.active_count == 0) return stiffness;
  const Unknowns root = inverse_roots(view);
  const CouplingStiffness& coupling = view.input.stiffness;
  RotationUnits units{Matrix3::Identity(), Matrix3::Identity(), Matrix3::Zero()};
  if (coupling.per_axis) {
    const Pose& X_WH = view.input.X_WH;
    units = rotation_units(coupling, X_WH.q,
                           coupling_error(view.state.X_WG, X_WH, view.state.phi_GH_W));
  }
  Span span;
  for (int k = 0; k < view.result.active_count; ++k) {
    const ActiveContact& active = view.result.active[static_cast<std::size_t>(k)];
    if (!(active.multiplier > 0.0)) continue;
    ContactRow row = contact_row(view, view.contact_of(active));
    if (coupling.per_axis) row.angular = units.T.transpose() * row.angular;
    span.add(scaled_row(row, root), unknowns);
  }
  for (std::size_t j = 0; j < span.count; ++j) {
    const Unknowns& q = span.q[j];
    const Vector3 along(q[0], q[1], q[2]);
    const Vector3 about(q[3], q[4], q[5]);
    if (coupling.per_axis) {
      const Vector3 f = along.cwiseProduct(coupling.along_W().cwiseSqrt());
      const Vector3 t = units.inverse.transpose() * about;
      stiffness.K_W += f * f.transpose();
      stiffness.Kr_W += t * t.transpose();
      continue;
    }
    stiffness.K_W += coupling.kt * along * along.transpose();
    stiffness.Kr_W += coupling.kr() * about * about.transpose();
  }
  return stiffness;
}

}  // namespace hapticd
