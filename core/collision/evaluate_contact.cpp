// Pairs of primitives at a given pose of the tool. See query.h. RT: yes.
#include <algorithm>
#include <limits>

#include "core/collision/blend_steepness.h"
#include "core/collision/primitives.h"

namespace hapticd {
namespace {

/// Finds the gaps of `count` pairs, those in a row with one obstacle together: go_on(batch, k) sees
/// those from pair `k` on, and says whether to go on.
template <typename KeyOf, typename GoOn>
void find_gaps(const PairSides& sides, std::size_t count, const KeyOf& key_of,
               const GoOn& go_on) noexcept {
  PairBatch batch(place_tool(sides.tool.X_WG));
  std::size_t next = 0;
  while (next < count) {
    const std::size_t first = next;
    const ContactKey& key = key_of(first);
    ask_primitive(key, [&](auto primitive) {
      primitive.begin(sides, key, batch);
      for (; next < count && !batch.full() && key_of(next).kind == key.kind &&
             primitive.same_obstacle(key_of(next), key);
           ++next) {
        primitive.add(sides, key_of(next), batch);
      }
    });
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
  const PairSides sides{tool, obstacles};
  return ask_primitive(key, [&](auto primitive) { return primitive.evaluate(sides, key); });
}

RoundObstacle round_obstacle(const Contact& contact, const ToolView& tool,
                             const ObstaclesView& obstacles) noexcept {
  const PairSides sides{tool, obstacles};
  return ask_primitive(contact.key,
                       [&](auto primitive) { return primitive.round(sides, contact); });
}

Matrix3 blend_curvature(const ContactKey& key, const ToolView& tool,
                        const ObstaclesView& obstacles) noexcept {
  return BodyGap::curvature_W({tool, obstacles}, key);
}

double blend_steepness(const ContactKey& key, const ToolView& tool,
                       const ObstaclesView& obstacles) noexcept {
  if (!is_blend(key)) return 1.0;
  const PairSides sides{tool, obstacles};
  const BodyView& view = obstacles.bodies[static_cast<std::size_t>(key.obstacle)];
  const PlacedBody body = place_body(view.X_WB, place_tool(tool.X_WG));
  return steepness_beside_blend(view.tree, to_body(body, sides.tool_sphere(key).p),
                                around(obstacles.blends, key.tool_sphere));
}

bool has_obstacle(const ContactKey& key, const ObstaclesView& obstacles) noexcept {
  return ask_primitive(key, [&](auto primitive) { return primitive.has(obstacles, key); });
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
