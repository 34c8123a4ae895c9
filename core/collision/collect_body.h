// All contacts of the tool with one body below the margin. Pairs are gathered into a batch of
// arrays, so that the compiler computes several contacts at once; each with the operations of
// core/collision/primitive_gap.h in their order, hence the same bits. RT: yes, about 10 ns per
// contact.
#pragma once

#include "core/collision/body_descent.h"
#include "core/collision/contact_collector.h"

namespace hapticd {

/// Makes contacts of the pairs that a BodyDescent finds.
class BodyContacts {
 public:
  BodyContacts(const PlacedTrees& trees, const ToolPlacement& tool_placement, std::int32_t obstacle,
               ContactCollector& collector) noexcept
      : trees_(trees),
        tool_placement_(tool_placement),
        obstacle_(obstacle),
        collector_(collector) {}

  /// Pairs that are certainly farther need not be reported, m.
  [[nodiscard]] double radius() const noexcept { return collector_.margin(); }
  void count_tests(int tests) noexcept { collector_.count_tests(tests); }

  /// Takes the pair of the tool's child i, whose centre is p_BC[i], and the body's child k.
  void hit(const NodePair& pair, int i, int k, const PointLanes& p_BC) noexcept {
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const SphereTreeNode& body = trees_.body.node(pair.body.part);
    const auto row = static_cast<std::size_t>(i);
    const auto lane = static_cast<std::size_t>(k);
    const std::size_t j = count_++;
    tool_id_[j] = trees_.tool.id(pair.tool.part, i);
    body_id_[j] = trees_.body.id(pair.body.part, k);
    offset_.x[j] = p_BC.x[row] - body.x[lane];
    offset_.y[j] = p_BC.y[row] - body.y[lane];
    offset_.z[j] = p_BC.z[row] - body.z[lane];
    p_GC_.x[j] = tool.x[row];
    p_GC_.y[j] = tool.y[row];
    p_GC_.z[j] = tool.z[row];
    r_tool_[j] = tool.r[row];
    radii_[j] = tool.r[row] + body.r[lane];
    if (count_ == kBatch) flush();
  }

  /// Adds what is still in the batch to the collector.
  void flush() noexcept {
    compute();
    for (std::size_t j = 0; j < count_; ++j) {
      if (!collector_.wants(tool_id_[j], gap_[j])) continue;
      collector_.add(gap_[j], [&](Contact& contact) { write(j, contact); });
    }
    count_ = 0;
  }

 private:
  static constexpr std::size_t kBatch = 64;
  using Numbers = std::array<double, kBatch>;
  struct Points {
    Numbers x, y, z;
  };

  // Without branches, and not inlined, so that it becomes vectors.
  [[gnu::noinline]] void compute() noexcept {
    const Matrix3 R_WB = trees_.placement.R_WB;
    const Matrix3 R_WG = tool_placement_.R_WG;
    const Vector3 p_WG = tool_placement_.p_WG;
    const std::size_t count = count_;
    for (std::size_t j = 0; j < count; ++j) {
      const double x = offset_.x[j];
      const double y = offset_.y[j];
      const double z = offset_.z[j];
      const double distance = std::sqrt((x * x + y * y) + z * z);
      const double inverse = 1.0 / distance;
      distance_[j] = distance;
      gap_[j] = distance - radii_[j];
      const Components n{x * inverse, y * inverse, z * inverse};
      const double nx = row_times(R_WB, 0, n);
      const double ny = row_times(R_WB, 1, n);
      const double nz = row_times(R_WB, 2, n);
      nhat_OG_W_.x[j] = nx;
      nhat_OG_W_.y[j] = ny;
      nhat_OG_W_.z[j] = nz;
      const Components c{p_GC_.x[j], p_GC_.y[j], p_GC_.z[j]};
      p_WC_.x[j] = (row_times(R_WG, 0, c) - r_tool_[j] * nx) + p_WG.x();
      p_WC_.y[j] = (row_times(R_WG, 1, c) - r_tool_[j] * ny) + p_WG.y();
      p_WC_.z[j] = (row_times(R_WG, 2, c) - r_tool_[j] * nz) + p_WG.z();
    }
  }

  // Number by number: a whole Contact, put together and then copied, would wait for its own stores.
  void write(std::size_t j, Contact& out) const noexcept {
    out.key = {ObstacleKind::kBody, obstacle_, tool_id_[j], body_id_[j]};
    if (distance_[j] < kMinLength) [[unlikely]] {
      const PrimitiveGap pair{Vector3::Zero(), distance_[j], gap_[j], 0.0};
      const Vector3 p_GC{p_GC_.x[j], p_GC_.y[j], p_GC_.z[j]};
      out = make_contact(out.key, pair, body_normal(pair, trees_.placement.R_WB),
                         {rotate(tool_placement_.R_WG, p_GC), r_tool_[j], tool_placement_.p_WG});
      return;
    }
    out.nhat_OG_W.x() = nhat_OG_W_.x[j];
    out.nhat_OG_W.y() = nhat_OG_W_.y[j];
    out.nhat_OG_W.z() = nhat_OG_W_.z[j];
    out.p_WC.x() = p_WC_.x[j];
    out.p_WC.y() = p_WC_.y[j];
    out.p_WC.z() = p_WC_.z[j];
    out.gap = gap_[j];
    out.lambda = 0.0;
  }

  const PlacedTrees& trees_;
  const ToolPlacement& tool_placement_;
  const std::int32_t obstacle_;
  ContactCollector& collector_;
  std::size_t count_ = 0;
  std::array<TreeSphereId, kBatch> tool_id_, body_id_;
  Points offset_;  ///< PrimitiveGap::offset, m; axes of B
  Points p_GC_;    ///< centres of the tool's spheres, m
  Numbers r_tool_, radii_;
  Numbers distance_, gap_;   ///< m
  Points nhat_OG_W_, p_WC_;  ///< as in Contact
};

}  // namespace hapticd
