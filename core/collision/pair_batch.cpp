// The loops over pairs: without branches, on their own numbers that no result can change, so
// that they become vectors. See pair_batch.h. RT: yes.
#include "core/collision/pair_batch.h"

#include <cmath>
#include <limits>

namespace hapticd {
void PairBatch::find_gaps() noexcept {
  for (std::size_t j = count_; j < whole_lanes(); ++j) repeat(count_ - 1, j);
  if (of_body_) {
    find_body_gaps();
  } else {
    find_capsule_gaps();
  }
}

void PairBatch::find_contacts() noexcept {
  if (of_body_) turn_to_world();
  const Matrix3 R_WG = tool_.R_WG;
  const Vector3 p_WG = tool_.p_WG;
  const std::size_t count = whole_lanes();
  for (std::size_t j = 0; j < count; ++j) {
    const Components c{p_GC_.x[j], p_GC_.y[j], p_GC_.z[j]};
    const double r = r_tool_[j];
    p_WC_.x[j] = (row_times(R_WG, 0, c) - r * nhat_.x[j]) + p_WG.x();
    p_WC_.y[j] = (row_times(R_WG, 1, c) - r * nhat_.y[j]) + p_WG.y();
    p_WC_.z[j] = (row_times(R_WG, 2, c) - r * nhat_.z[j]) + p_WG.z();
  }
}

void PairBatch::find_body_gaps() noexcept {
  const Matrix3 R_BG = body_.R_BG;
  const Vector3 p_BG = body_.p_BG;
  const std::size_t count = whole_lanes();
  for (std::size_t j = 0; j < count; ++j) {
    const Components c{p_GC_.x[j], p_GC_.y[j], p_GC_.z[j]};
    const double x = (row_times(R_BG, 0, c) + p_BG.x()) - p_B_.x[j];
    const double y = (row_times(R_BG, 1, c) + p_BG.y()) - p_B_.y[j];
    const double z = (row_times(R_BG, 2, c) + p_BG.z()) - p_B_.z[j];
    const double distance = std::sqrt((x * x + y * y) + z * z);
    offset_.x[j] = x;
    offset_.y[j] = y;
    offset_.z[j] = z;
    distance_[j] = distance;
    gap_[j] = distance - (r_tool_[j] + r_body_[j]);
  }
}

void PairBatch::turn_to_world() noexcept {
  const Matrix3 R_WB = body_.R_WB;
  const std::size_t count = whole_lanes();
  for (std::size_t j = 0; j < count; ++j) {
    const double inverse = 1.0 / distance_[j];
    const Components n{offset_.x[j] * inverse, offset_.y[j] * inverse, offset_.z[j] * inverse};
    nhat_.x[j] = row_times(R_WB, 0, n);
    nhat_.y[j] = row_times(R_WB, 1, n);
    nhat_.z[j] = row_times(R_WB, 2, n);
    lambda_[j] = 0.0;
  }
}

void PairBatch::find_capsule_gaps() noexcept {
  const PlacedCapsule capsule = place_capsule(segment_.capsule_W, tool_.p_WG);
  const Vector3 a = capsule.p_GA_W;
  const Vector3 ab = capsule.p_GB_W - capsule.p_GA_W;
  const double square = (ab.x() * ab.x() + ab.y() * ab.y()) + ab.z() * ab.z();
  // Where the axis vanishes all are at lambda 0.
  const double divisor =
      square >= kMinLength * kMinLength ? square : std::numeric_limits<double>::infinity();
  const double from = segment_.lambda_from;
  const double span = segment_.lambda_to - segment_.lambda_from;
  const Matrix3 R_WG = tool_.R_WG;
  const std::size_t count = whole_lanes();
  for (std::size_t j = 0; j < count; ++j) {
    const Components c{p_GC_.x[j], p_GC_.y[j], p_GC_.z[j]};
    const double acx = row_times(R_WG, 0, c) - a.x();
    const double acy = row_times(R_WG, 1, c) - a.y();
    const double acz = row_times(R_WG, 2, c) - a.z();
    double lambda = ((acx * ab.x() + acy * ab.y()) + acz * ab.z()) / divisor;
    lambda = lambda > 0.0 ? lambda : 0.0;
    lambda = lambda < 1.0 ? lambda : 1.0;
    const double x = acx - lambda * ab.x();
    const double y = acy - lambda * ab.y();
    const double z = acz - lambda * ab.z();
    const double distance = std::sqrt((x * x + y * y) + z * z);
    const double inverse = 1.0 / distance;
    distance_[j] = distance;
    gap_[j] = distance - (r_tool_[j] + capsule.r);
    lambda_[j] = from + lambda * span;
    nhat_.x[j] = x * inverse;
    nhat_.y[j] = y * inverse;
    nhat_.z[j] = z * inverse;
  }
}

Contact PairBatch::concentric(std::size_t j, const ContactKey& key) const noexcept {
  const PrimitiveGap pair{Vector3::Zero(), distance_[j], gap_[j], lambda_[j]};
  const Vector3 normal =
      of_body_ ? body_normal(pair, body_.R_WB)
               : capsule_normal(pair, segment_.capsule_W.p_B - segment_.capsule_W.p_A);
  return make_contact(key, pair, normal, {rotate(tool_.R_WG, p_GC_.at(j)), r_tool_[j], tool_.p_WG});
}

}  // namespace hapticd
