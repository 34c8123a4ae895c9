// First all contacts below the margin; only where there are none, the search for the smallest gap:
// a tool in touch never pays for it, and a tool far off leaves the first pass at the root. See
// query.h. RT: yes.
#include "core/collision/query.h"

#include "core/collision/primitives.h"
#include "core/math/cpu.h"

namespace hapticd {
namespace {

template <typename Kernels>
void collect_contacts(const PlacedQuery& query, ContactCollector& collector) noexcept {
  for_each_primitive(
      [&](auto primitive) { decltype(primitive)::template collect<Kernels>(query, collector); });
}

/// Contacts of the displaced parts: the tool stands where their displacement puts it, and only
/// their spheres count.
template <typename Kernels>
void collect_displaced(const PlacedQuery& query, const DisplacedParts& displaced,
                       ContactCollector& collector) noexcept {
  int index = 0;
  for (const PartDisplacement& part : displaced.parts) {
    PlacedQuery moved = query;
    moved.placement.p_WG += rotate(query.placement.R_WG, part.v_G);
    collector.look_at(displaced, index++);
    collect_contacts<Kernels>(moved, collector);
  }
}

template <typename Kernels>
void find(const PlacedQuery& query, const DisplacedParts& displaced, ContactSet& out) noexcept {
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
  for_each_primitive(
      [&](auto primitive) { decltype(primitive)::template find_nearest<Kernels>(query, nearest); });
  out.minimum_gap =
      displaced.parts.empty() ? nearest.gap : std::max(query.options.margin, nearest.gap - aside);
  out.tests += nearest.tests;
}

}  // namespace

void find_contacts(const ToolView& tool, const ObstaclesView& obstacles,
                   const QueryOptions& options, ContactSet& out) noexcept {
  HD_ASSERT(tool.displaced.parts.empty() || options.tool_level == kLeafLevel);
  const PlacedQuery query{levelled(tool.tree, options.tool_level), place_tool(tool.X_WG), obstacles,
                          options};
  if (avx2_available()) {
    find<Avx2Kernels>(query, tool.displaced, out);
  } else {
    find<PortableKernels>(query, tool.displaced, out);
  }
}

}  // namespace hapticd
