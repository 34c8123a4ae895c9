// First all contacts below the margin; only where there are none, the search for the smallest gap:
// a tool in touch never pays for it, and a tool far off leaves the first pass at the root. See
// query.h. RT: yes.
#include "core/collision/query.h"

#include "core/collision/collect_body.h"
#include "core/collision/collect_capsule.h"
#include "core/collision/nearest_gap.h"
#include "core/math/cpu.h"

namespace hapticd {
namespace {

LevelledTree levelled(const SphereTreeView& tree, int level) noexcept {
  HD_ASSERT(tree.depth <= kMaxTreeDepth);
  return {tree, level};
}

/// One query: tool, obstacles, and how far down their trees it goes.
struct Query {
  LevelledTree tool;
  ToolPlacement placement;
  const ObstaclesView& obstacles;
  const QueryOptions& options;
};

PlacedTrees placed(const Query& query, const BodyView& body) noexcept {
  return place_trees(query.tool, query.placement, levelled(body.tree, query.options.body_level),
                     body.X_WB);
}

/// Where anything must be that is nearer to the tool than `gap`: around its origin, with room for
/// rounding.
Neighbourhood neighbourhood(const Query& query, double gap) noexcept {
  const double radius =
      gap + reach(query.tool.tree) + surface_overhang(query.tool.tree, query.tool.last_level);
  return {query.placement.p_WG, radius + kRelativeSlack * (radius + length(query.placement.p_WG))};
}

/// What all of the tool lies in, however far down its tree a query goes.
struct ToolBall {
  Vector3 p_W;
  double radius;  ///< m
  double reach;   ///< of the tool from its origin, m
};

ToolBall ball_of(const Query& query) noexcept {
  const SphereTreeView& tool = query.tool.tree;
  return {rotate(query.placement.R_WG, tool.bound.p) + query.placement.p_WG,
          tool.bound.r + surface_overhang(tool, query.tool.last_level), reach(tool)};
}

/// True when the ball around the tool is certainly farther than `gap` from the box around a body;
/// for that the body need not be placed.
bool out_of_reach(const Query& query, const ToolBall& ball, const BodyView& body,
                  double gap) noexcept {
  const NodeBox* const boxes = levelled(body.tree, query.options.body_level).boxes();
  if (boxes == nullptr) return false;
  const Vector3 from_body_W = ball.p_W - body.X_WB.p;
  const Vector3 p_BC = rotate(rotation_matrix(body.X_WB.q).transpose(), from_body_W);
  const double slack = kRelativeSlack * (length(from_body_W) + ball.reach + reach(body.tree));
  const double radius = gap + ball.radius + slack;
  return radius > 0.0 && !may_touch({boxes->lower, boxes->upper}, {p_BC, radius});
}

template <typename Kernels>
void collect_contacts(const Query& query, ContactCollector& collector) noexcept {
  for_each_segment(query.obstacles, neighbourhood(query, query.options.margin),
                   [&](std::int32_t capsule, const AxisSegment& segment) {
                     collect_capsule<Kernels>(query.tool, query.placement, segment, capsule,
                                              collector);
                   });
  if (query.obstacles.bodies.empty()) return;
  const ToolBall ball = ball_of(query);
  std::int32_t index = 0;
  for (const BodyView& body : query.obstacles.bodies) {
    const std::int32_t number = index++;
    if (out_of_reach(query, ball, body, collector.margin())) continue;
    const PlacedTrees trees = placed(query, body);
    BodyContacts contacts(trees, query.placement, number, collector);
    BodyDescent<Kernels, BodyContacts>(trees, contacts).run();
    contacts.flush();
  }
}

/// Contacts of the displaced parts: the tool stands where their displacement puts it, and only
/// their spheres count.
template <typename Kernels>
void collect_displaced(const Query& query, const DisplacedParts& displaced,
                       ContactCollector& collector) noexcept {
  int index = 0;
  for (const PartDisplacement& part : displaced.parts) {
    Query moved = query;
    moved.placement.p_WG += rotate(query.placement.R_WG, part.v_G);
    collector.look_at(displaced, index++);
    collect_contacts<Kernels>(moved, collector);
  }
}

template <typename Kernels>
void find_nearest(const Query& query, NearestGap& nearest) noexcept {
  for_each_segment(query.obstacles, neighbourhood(query, nearest.gap),
                   [&](std::int32_t, const AxisSegment& segment) {
                     nearest_on_capsule<Kernels>(query.tool, query.placement, segment.capsule_W,
                                                 nearest);
                   });
  if (query.obstacles.bodies.empty()) return;
  const ToolBall ball = ball_of(query);
  for (const BodyView& body : query.obstacles.bodies) {
    if (out_of_reach(query, ball, body, nearest.gap)) continue;
    nearest_on_body<Kernels>(placed(query, body), nearest);
  }
}

template <typename Kernels>
void find(const Query& query, const DisplacedParts& displaced, ContactSet& out) noexcept {
  ContactCollector collector(query.options.margin, out);
  if (!displaced.parts.empty()) collector.look_at(displaced, -1);
  collect_contacts<Kernels>(query, collector);
  if (!displaced.parts.empty()) collect_displaced<Kernels>(query, displaced, collector);
  collector.finish();
  if (!out.contacts.empty()) {
    out.minimum_gap = std::min(query.options.horizon, collector.nearest());
    return;
  }
  // The search knows the tool as its tree has it; a part is no nearer than it is displaced, nor
  // than the margin.
  const double aside = displaced.greatest();
  NearestGap nearest{query.options.horizon + aside};
  find_nearest<Kernels>(query, nearest);
  out.minimum_gap =
      displaced.parts.empty() ? nearest.gap : std::max(query.options.margin, nearest.gap - aside);
  out.tests += nearest.tests;
}

}  // namespace

void find_contacts(const ToolView& tool, const ObstaclesView& obstacles,
                   const QueryOptions& options, ContactSet& out) noexcept {
  HD_ASSERT(tool.displaced.parts.empty() || options.tool_level == kLeafLevel);
  const Query query{levelled(tool.tree, options.tool_level), place_tool(tool.X_WG), obstacles,
                    options};
  if (avx2_available()) {
    find<Avx2Kernels>(query, tool.displaced, out);
  } else {
    find<PortableKernels>(query, tool.displaced, out);
  }
}

}  // namespace hapticd
