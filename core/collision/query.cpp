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

template <typename Kernels>
double collect_contacts(const Query& query, ContactSet& out) noexcept {
  ContactCollector collector(query.options.margin, out);
  for_each_segment(query.obstacles, neighbourhood(query, query.options.margin),
                   [&](std::int32_t capsule, const AxisSegment& segment) {
                     collect_capsule<Kernels>(query.tool, query.placement, segment, capsule,
                                              collector);
                   });
  std::int32_t index = 0;
  for (const BodyView& body : query.obstacles.bodies) {
    const PlacedTrees trees = placed(query, body);
    BodyContacts contacts(trees, query.placement, index++, collector);
    BodyDescent<Kernels, BodyContacts>(trees, contacts).run();
    contacts.flush();
  }
  return collector.nearest();
}

template <typename Kernels>
void find_nearest(const Query& query, NearestGap& nearest) noexcept {
  for_each_segment(query.obstacles, neighbourhood(query, nearest.gap),
                   [&](std::int32_t, const AxisSegment& segment) {
                     nearest_on_capsule<Kernels>(query.tool, query.placement, segment.capsule_W,
                                                 nearest);
                   });
  for (const BodyView& body : query.obstacles.bodies) {
    nearest_on_body<Kernels>(placed(query, body), nearest);
  }
}

template <typename Kernels>
void find(const Query& query, ContactSet& out) noexcept {
  const double smallest = collect_contacts<Kernels>(query, out);
  NearestGap nearest{std::min(query.options.horizon, smallest)};
  if (out.contacts.empty()) find_nearest<Kernels>(query, nearest);
  out.minimum_gap = nearest.gap;
  out.tests += nearest.tests;
}

}  // namespace

void find_contacts(const SphereTreeView& tool, const Pose& X_WG, const ObstaclesView& obstacles,
                   const QueryOptions& options, ContactSet& out) noexcept {
  const Query query{levelled(tool, options.tool_level), place_tool(X_WG), obstacles, options};
  if (avx2_available()) {
    find<Avx2Kernels>(query, out);
  } else {
    find<PortableKernels>(query, out);
  }
}

}  // namespace hapticd
