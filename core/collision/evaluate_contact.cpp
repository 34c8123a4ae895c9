// Pairs of primitives at a given pose of the tool. See query.h. RT: yes.
#include <algorithm>
#include <limits>

#include "core/collision/pair_batch.h"
#include "core/collision/query.h"

namespace hapticd {
namespace {

/// Between what pairs are evaluated.
struct Sides {
  const ToolView& tool;
  const ObstaclesView& obstacles;

  [[nodiscard]] Sphere tool_sphere(const ContactKey& key) const noexcept {
    const DisplacedParts& displaced = tool.displaced;
    Sphere sphere_G = tree_sphere(tool.tree, key.tool_sphere);
    if (displaced.parts.empty()) return sphere_G;
    const int k = displaced.find(key.tool_sphere);
    if (k >= 0) sphere_G.p += displaced.parts[static_cast<std::size_t>(k)].v_G;
    return sphere_G;
  }
  [[nodiscard]] const BodyView& body(const ContactKey& key) const noexcept {
    return obstacles.bodies[static_cast<std::size_t>(key.obstacle)];
  }
};

/// True when a pair is with the same body or leg of a string as `other`.
bool same_obstacle(const ContactKey& key, const ContactKey& other) noexcept {
  return key.kind == other.kind && key.obstacle == other.obstacle &&
         (is_body(key) || key.obstacle_sphere == other.obstacle_sphere);
}

/// Begins with the pair `key` is of.
void begin(const Sides& sides, const ContactKey& key, PairBatch& batch) noexcept {
  if (is_body(key)) {
    batch.begin(sides.body(key).X_WB);
  } else {
    batch.begin(segment_of(sides.obstacles, key.obstacle, key.obstacle_sphere));
  }
}

void add(const Sides& sides, const ContactKey& key, PairBatch& batch) noexcept {
  if (is_body(key)) {
    batch.add(sides.tool_sphere(key), tree_sphere(sides.body(key).tree, key.obstacle_sphere));
  } else {
    batch.add(sides.tool_sphere(key));
  }
}

/// Finds the gaps of `count` pairs, those in a row with one obstacle together: go_on(batch, k) sees
/// those from pair `k` on, and says whether to go on.
template <typename KeyOf, typename GoOn>
void find_gaps(const Sides& sides, std::size_t count, const KeyOf& key_of,
               const GoOn& go_on) noexcept {
  PairBatch batch(place_tool(sides.tool.X_WG));
  std::size_t next = 0;
  while (next < count) {
    const std::size_t first = next;
    const ContactKey& key = key_of(first);
    begin(sides, key, batch);
    for (; next < count && !batch.full() && same_obstacle(key_of(next), key); ++next) {
      add(sides, key_of(next), batch);
    }
    batch.find_gaps();
    if (!go_on(batch, first)) return;
  }
}

double minimum_gap(const PairBatch& batch, double minimum) noexcept {
  for (std::size_t j = 0; j < batch.size(); ++j) {
    minimum = batch.gap(j) < minimum ? batch.gap(j) : minimum;
  }
  return minimum;
}

}  // namespace

Contact evaluate_contact(const ContactKey& key, const ToolView& tool,
                         const ObstaclesView& obstacles) noexcept {
  const Sides sides{tool, obstacles};
  const ToolPlacement placement = place_tool(tool.X_WG);
  const Sphere sphere_G = sides.tool_sphere(key);
  const PlacedSphere placed{rotate(placement.R_WG, sphere_G.p), sphere_G.r, placement.p_WG};
  if (is_body(key)) {
    const BodyView& view = sides.body(key);
    const PlacedBody body = place_body(view.X_WB, placement);
    const PrimitiveGap pair = gap_to_body_sphere(to_body(body, sphere_G.p), sphere_G.r,
                                                 tree_sphere(view.tree, key.obstacle_sphere));
    return make_contact(key, pair, body_normal(pair, body.R_WB), placed);
  }
  const AxisSegment segment = segment_of(obstacles, key.obstacle, key.obstacle_sphere);
  const Capsule& capsule = segment.capsule_W;
  PrimitiveGap pair =
      gap_to_capsule(placed.p_GC_W, placed.r, place_capsule(capsule, placement.p_WG));
  pair.lambda = string_lambda(segment, pair.lambda);
  return make_contact(key, pair, capsule_normal(pair, capsule.p_B - capsule.p_A), placed);
}

void evaluate_contacts(const ToolView& tool, const ObstaclesView& obstacles,
                       ContactSet& contacts) noexcept {
  auto& all = contacts.contacts;
  double minimum = std::numeric_limits<double>::infinity();
  find_gaps(
      {tool, obstacles}, all.size(),
      [&all](std::size_t k) -> const ContactKey& { return all[k].key; },
      [&](PairBatch& batch, std::size_t first) {
        batch.find_contacts();
        for (std::size_t j = 0; j < batch.size(); ++j) batch.write(j, all[first + j]);
        minimum = minimum_gap(batch, minimum);
        return true;
      });
  contacts.minimum_gap = minimum;
}

bool any_gap_below(double least, const ContactSubset& contacts, const ToolView& tool,
                   const ObstaclesView& obstacles) noexcept {
  bool below = false;
  find_gaps(
      {tool, obstacles}, contacts.which.size(),
      [&](std::size_t k) -> const ContactKey& {
        return contacts.set.contacts[static_cast<std::size_t>(contacts.which[k])].key;
      },
      [&](const PairBatch& batch, std::size_t) {
        below = minimum_gap(batch, least) < least;
        return !below;
      });
  return below;
}

double minimum_gap_of(const ContactSet& contacts, const ToolView& tool,
                      const ObstaclesView& obstacles) noexcept {
  double minimum = std::numeric_limits<double>::infinity();
  find_gaps(
      {tool, obstacles}, contacts.contacts.size(),
      [&contacts](std::size_t k) -> const ContactKey& { return contacts.contacts[k].key; },
      [&minimum](const PairBatch& batch, std::size_t) {
        minimum = minimum_gap(batch, minimum);
        return true;
      });
  return minimum;
}

}  // namespace hapticd
