// The primitive of bodies: sphere-trees, placed. All contacts of the tool with one below the
// margin, gathered into a batch of arrays, so that the compiler computes several at once, each with
// the operations of core/collision/primitive_gap.h in their order, hence the same bits; and the
// smallest gap, from that of a pair that is likely to be near. RT: yes, about 10 ns per contact.
#pragma once

#include <algorithm>

#include "core/collision/blended_surface.h"
#include "core/collision/pair_batch.h"
#include "core/collision/placed_query.h"
#include "core/collision/seen_spheres.h"

namespace hapticd {

inline PlacedTrees placed(const PlacedQuery& query, const BodyView& body) noexcept {
  return place_trees(query.tool, query.placement, levelled(body.tree, query.options.body_level),
                     body.X_WB);
}

/// What all of the tool lies in, however far down its tree a query goes.
struct ToolBall {
  Vector3 p_W;
  double radius;  ///< m
  double reach;   ///< of the tool from its origin, m
};

inline ToolBall ball_of(const PlacedQuery& query) noexcept {
  const SphereTreeView& tool = query.tool.tree;
  return {rotate(query.placement.R_WG, tool.bound.p) + query.placement.p_WG,
          tool.bound.r + surface_overhang(tool, query.tool.last_level), reach(tool)};
}

/// True when the ball around the tool is certainly farther than `gap` from the box around a body;
/// for that the body need not be placed.
inline bool out_of_reach(const PlacedQuery& query, const ToolBall& ball, const BodyView& body,
                         double gap) noexcept {
  const NodeBox* const boxes = levelled(body.tree, query.options.body_level).boxes();
  if (boxes == nullptr) return false;
  const Vector3 from_body_W = ball.p_W - body.X_WB.p;
  const Vector3 p_BC = rotate(rotation_matrix(body.X_WB.q).transpose(), from_body_W);
  const double slack = kRelativeSlack * (length(from_body_W) + ball.reach + reach(body.tree));
  const double radius = gap + ball.radius + slack + blend_reach(body.tree);
  return radius > 0.0 && !may_touch({boxes->lower, boxes->upper}, {p_BC, radius});
}

/// Makes contacts of the pairs that a BodyDescent finds.
class BodyContacts {
 public:
  static constexpr bool kOnce = false;

  BodyContacts(const PlacedTrees& trees, const ToolPlacement& tool_placement, std::int32_t obstacle,
               ContactCollector& collector) noexcept
      : trees_(trees),
        tool_placement_(tool_placement),
        obstacle_(obstacle),
        collector_(collector),
        beyond_(blend_reach(trees.body.tree)) {}

  /// Pairs that are certainly farther need not be reported, m.
  [[nodiscard]] double radius() const noexcept { return collector_.margin() + beyond_; }
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
    radii_[j] = tool.r[row] + (body.r[lane] + beyond_);
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
  const double beyond_;  ///< added to the body's spheres, m
  std::size_t count_ = 0;
  std::array<TreeSphereId, kBatch> tool_id_, body_id_;
  Points offset_;  ///< PrimitiveGap::offset, m; axes of B
  Points p_GC_;    ///< centres of the tool's spheres, m
  Numbers r_tool_, radii_;
  Numbers distance_, gap_;   ///< m
  Points nhat_OG_W_, p_WC_;  ///< as in Contact
};

/// What is remembered of a tool sphere; null: nothing is.
inline LeavesAround* around(BlendMemory* blends, TreeSphereId tool_sphere) noexcept {
  return blends == nullptr ? nullptr : &blends->around(tool_sphere);
}

/// Makes the contacts of the tool's spheres with the blended surface of a body, one each.
class BlendContacts {
 public:
  static constexpr bool kOnce = true;

  BlendContacts(const PlacedTrees& trees, const PlacedQuery& query, std::int32_t obstacle,
                ContactCollector& collector) noexcept
      : trees_(trees),
        tool_placement_(query.placement),
        blends_(query.obstacles.blends),
        obstacle_(obstacle),
        collector_(collector) {}

  [[nodiscard]] double radius() const noexcept {
    return collector_.margin() + blend_reach(trees_.body.tree);
  }
  [[nodiscard]] unsigned done(const TreePart& tool) const noexcept { return seen_.of(tool); }
  void count_tests(int tests) noexcept { collector_.count_tests(tests); }

  void hit(const NodePair& pair, int i, int /*k*/, const PointLanes& p_BC) noexcept {
    const ContactKey key{ObstacleKind::kBody, obstacle_, trees_.tool.id(pair.tool.part, i),
                         kBlendedSurface};
    if ((seen_.of(pair.tool.part) >> i & 1U) != 0) return;
    seen_.add(pair.tool.part, i);
    if (!collector_.counts(key.tool_sphere)) return;
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const auto row = static_cast<std::size_t>(i);
    const BlendedPlace place =
        place_beside_blend(trees_.body.tree, p_BC[row], around(blends_, key.tool_sphere));
    collector_.count_tests(kBlendTests);
    const PrimitiveGap gap = gap_to_blend(place, tool.r[row]);
    if (!collector_.wants(key.tool_sphere, gap.gap)) return;
    if (seen_.forgot() && collector_.holds(key)) return;
    const Vector3 p_GC{tool.x[row], tool.y[row], tool.z[row]};
    const PlacedSphere placed{rotate(tool_placement_.R_WG, p_GC), tool.r[row],
                              tool_placement_.p_WG};
    collector_.add(gap.gap, [&](Contact& contact) {
      contact = make_contact(key, gap, body_normal(gap, trees_.placement.R_WB), placed);
    });
  }

 private:
  const PlacedTrees& trees_;
  const ToolPlacement& tool_placement_;
  BlendMemory* const blends_;
  const std::int32_t obstacle_;
  ContactCollector& collector_;
  SeenSpheres seen_;
};

/// Lowers a NearestGap to those of a blended surface.
class NearestBlend {
 public:
  static constexpr bool kOnce = true;

  NearestBlend(const PlacedTrees& trees, BlendMemory* blends, NearestGap& nearest) noexcept
      : trees_(trees), blends_(blends), nearest_(nearest) {}

  [[nodiscard]] double radius() const noexcept {
    return nearest_.gap + blend_reach(trees_.body.tree);
  }
  [[nodiscard]] unsigned done(const TreePart& tool) const noexcept { return seen_.of(tool); }
  void count_tests(int tests) noexcept { nearest_.tests += tests; }

  void hit(const NodePair& pair, int i, int /*k*/, const PointLanes& p_BC) noexcept {
    const TreeSphereId tool_sphere = trees_.tool.id(pair.tool.part, i);
    if ((seen_.of(pair.tool.part) >> i & 1U) != 0) return;
    seen_.add(pair.tool.part, i);
    const auto row = static_cast<std::size_t>(i);
    const BlendedPlace place =
        place_beside_blend(trees_.body.tree, p_BC[row], around(blends_, tool_sphere));
    nearest_.tests += kBlendTests;
    nearest_.gap = std::min(nearest_.gap, place.distance - trees_.tool.node(pair.tool.part).r[row]);
  }

 private:
  const PlacedTrees& trees_;
  BlendMemory* const blends_;
  NearestGap& nearest_;
  SeenSpheres seen_;
};

/// Rounds of dives before the search proper. Normal value 2. Costs only time: the better the first
/// gap, the fewer parts are opened.
inline constexpr int kDives = 2;

/// Lowers a NearestGap to the gaps of the pairs that a BodyDescent finds.
class NearestPair {
 public:
  static constexpr bool kOnce = false;

  NearestPair(const PlacedTrees& trees, NearestGap& nearest) noexcept
      : trees_(trees), nearest_(nearest), beyond_(blend_reach(trees.body.tree)) {}

  [[nodiscard]] double radius() const noexcept { return nearest_.gap + beyond_; }
  void count_tests(int tests) noexcept { nearest_.tests += tests; }

  void hit(const NodePair& pair, int i, int k, const PointLanes& p_BC) noexcept {
    const SphereTreeNode& tool = trees_.tool.node(pair.tool.part);
    const SphereTreeNode& body = trees_.body.node(pair.body.part);
    const auto row = static_cast<std::size_t>(i);
    const auto lane = static_cast<std::size_t>(k);
    const PrimitiveGap gap =
        gap_to_body_sphere(p_BC[row], tool.r[row],
                           {{body.x[lane], body.y[lane], body.z[lane]}, body.r[lane] + beyond_});
    nearest_.gap = std::min(nearest_.gap, gap.gap);
  }

 private:
  const PlacedTrees& trees_;
  NearestGap& nearest_;
  const double beyond_;  ///< added to the body's spheres, m
};

/// The surface sphere where always taking the child nearest to `probe` ends.
template <typename Kernels>
[[nodiscard]] Sphere dive(const LevelledTree& tree, const Vector3& probe,
                          std::int64_t& tests) noexcept {
  TreePart part = LevelledTree::root();
  for (;;) {
    const SphereTreeNode& node = tree.node(part);
    Lanes lower;
    Kernels::bounds(lanes_of(node), SphereProbe{probe, 0.0}, lower);
    tests += kTreeWidth;
    const auto k =
        static_cast<std::size_t>(std::min_element(lower.begin(), lower.end()) - lower.begin());
    if ((tree.inner(part) >> k & 1U) == 0) return {{node.x[k], node.y[k], node.z[k]}, node.r[k]};
    part = tree.child(part, static_cast<int>(k));
  }
}

/// Gap of a pair that is probably among the nearest: each sphere the nearest to the other, in turn.
template <typename Kernels>
[[nodiscard]] double gap_of_dives(const PlacedTrees& trees, std::int64_t& tests) noexcept {
  const PlacedBody& placement = trees.placement;
  const Matrix3 R_GB = placement.R_BG.transpose();
  Vector3 p_BC = to_body(placement, trees.tool.tree.bound.p);
  double gap = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kDives; ++k) {
    const Sphere body = dive<Kernels>(trees.body, p_BC, tests);
    const Sphere tool = dive<Kernels>(trees.tool, rotate(R_GB, body.p - placement.p_BG), tests);
    p_BC = to_body(placement, tool.p);
    gap = std::min(gap, gap_to_body_sphere(p_BC, tool.r, body).gap);
  }
  return gap;
}

/// Lowers `nearest` to the gap of the tool to a body.
template <typename Kernels>
void nearest_on_body(const PlacedTrees& trees, BlendMemory* blends, NearestGap& nearest) noexcept {
  const Sphere& bound_G = trees.tool.tree.bound;
  const PrimitiveGap bounds =
      gap_to_body_sphere(to_body(trees.placement, bound_G.p), bound_G.r, trees.body.tree.bound);
  if (bounds.gap - trees.slack - blend_reach(trees.body.tree) > nearest.gap) return;
  // A blended surface is no farther than its leaves.
  nearest.gap = std::min(nearest.gap, gap_of_dives<Kernels>(trees, nearest.tests));
  if (meets_blend(trees.body.tree, trees.body.last_level)) {
    NearestBlend visitor(trees, blends, nearest);
    BodyDescent<Kernels, NearestBlend>(trees, visitor).run();
    return;
  }
  NearestPair visitor(trees, nearest);
  BodyDescent<Kernels, NearestPair>(trees, visitor).run();
}

/// See primitives.h.
struct BodyGap {
  static bool same_obstacle(const ContactKey& key, const ContactKey& other) noexcept {
    return key.obstacle == other.obstacle;
  }

  static bool has(const ObstaclesView& obstacles, const ContactKey& key) noexcept {
    return static_cast<std::size_t>(key.obstacle) < obstacles.bodies.size() &&
           has_sphere(body_of(obstacles, key).tree, key.obstacle_sphere);
  }

  static RoundObstacle round(const PairSides& sides, const Contact& contact) noexcept {
    return {sphere_of(body_of(sides.obstacles, contact.key), contact.key).r, Vector3::Zero()};
  }

  /// blend_curvature() of query.h.
  static Matrix3 curvature_W(const PairSides& sides, const ContactKey& key) noexcept {
    const BodyView& view = body_of(sides.obstacles, key);
    const PlacedBody body = place_body(view.X_WB, place_tool(sides.tool.X_WG));
    const BlendedPlace place =
        place_beside_blend(view.tree, to_body(body, sides.tool_sphere(key).p),
                           around(sides.obstacles.blends, key.tool_sphere));
    return body.R_WB * place.curvature_B * body.R_WB.transpose();
  }

  static Contact evaluate(const PairSides& sides, const ContactKey& key) noexcept {
    const ToolPlacement placement = place_tool(sides.tool.X_WG);
    const Sphere sphere_G = sides.tool_sphere(key);
    const PlacedSphere placed{rotate(placement.R_WG, sphere_G.p), sphere_G.r, placement.p_WG};
    const BodyView& view = body_of(sides.obstacles, key);
    const PlacedBody body = place_body(view.X_WB, placement);
    const Vector3 p_BC = to_body(body, sphere_G.p);
    const PrimitiveGap pair =
        of_blend(key)
            ? gap_to_blend(place_beside_blend(view.tree, p_BC,
                                              around(sides.obstacles.blends, key.tool_sphere)),
                           sphere_G.r)
            : gap_to_body_sphere(p_BC, sphere_G.r, sphere_of(view, key));
    return make_contact(key, pair, body_normal(pair, body.R_WB), placed);
  }

  static void begin(const PairSides& sides, const ContactKey& key, PairBatch& batch) noexcept {
    batch.begin(body_of(sides.obstacles, key).X_WB);
  }
  static void add(const PairSides& sides, const ContactKey& key, PairBatch& batch) noexcept {
    const BodyView& body = body_of(sides.obstacles, key);
    const Sphere sphere_G = sides.tool_sphere(key);
    if (!of_blend(key)) {
      batch.add(sphere_G, sphere_of(body, key));
      return;
    }
    const Vector3 p_BC = batch.in_body(sphere_G);
    batch.add(sphere_G,
              tangent_sphere(place_beside_blend(body.tree, p_BC,
                                                around(sides.obstacles.blends, key.tool_sphere)),
                             p_BC));
  }

  template <typename Kernels>
  static void collect(const PlacedQuery& query, ContactCollector& collector) noexcept {
    if (query.obstacles.bodies.empty()) return;
    const ToolBall ball = ball_of(query);
    std::int32_t index = 0;
    for (const BodyView& body : query.obstacles.bodies) {
      const std::int32_t number = index++;
      if (out_of_reach(query, ball, body, collector.margin())) continue;
      const PlacedTrees trees = placed(query, body);
      if (meets_blend(body.tree, trees.body.last_level)) {
        BlendContacts contacts(trees, query, number, collector);
        BodyDescent<Kernels, BlendContacts>(trees, contacts).run();
        continue;
      }
      BodyContacts contacts(trees, query.placement, number, collector);
      BodyDescent<Kernels, BodyContacts>(trees, contacts).run();
      contacts.flush();
    }
  }

  template <typename Kernels>
  static void find_nearest(const PlacedQuery& query, NearestGap& nearest) noexcept {
    if (query.obstacles.bodies.empty()) return;
    const ToolBall ball = ball_of(query);
    for (const BodyView& body : query.obstacles.bodies) {
      if (out_of_reach(query, ball, body, nearest.gap)) continue;
      nearest_on_body<Kernels>(placed(query, body), query.obstacles.blends, nearest);
    }
  }

 private:
  static bool of_blend(const ContactKey& key) noexcept {
    return key.obstacle_sphere == kBlendedSurface;
  }
  /// The sphere of a pair that a query of coarse levels, or of no blend, has found.
  static Sphere sphere_of(const BodyView& body, const ContactKey& key) noexcept {
    Sphere sphere = tree_sphere(body.tree, key.obstacle_sphere);
    sphere.r += blend_reach(body.tree);
    return sphere;
  }
  static const BodyView& body_of(const ObstaclesView& obstacles, const ContactKey& key) noexcept {
    return obstacles.bodies[static_cast<std::size_t>(key.obstacle)];
  }
};

}  // namespace hapticd
