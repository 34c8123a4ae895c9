// The primitives that a tool can touch, one a line; each is a class of static functions in its
// NAME_gap.h, over the obstacles of its kind:
//
// - same_obstacle: whether two pairs are with one obstacle, to be evaluated together
// - has: whether there is what a pair is with
// - round: how the obstacle is round where it is touched
// - evaluate: gap, normal and contact point of one pair
// - begin, add: the same of many pairs with one obstacle
// - collect: all pairs below the margin, by bounds
// - find_nearest: the smallest gap, by bounds
//
// Internal to the folder: outside of it is_string(key) and is_body(key) tell them apart. RT: yes.
#pragma once

#include "core/collision/body_gap.h"
#include "core/collision/capsule_gap.h"

namespace hapticd {

/// visit(primitive) of all, in the order of ObstacleKind.
template <typename Visit>
void for_each_primitive(const Visit& visit) noexcept {
  visit(CapsuleGap{});
  visit(BodyGap{});
}

/// ask(primitive) of that which the pair `key` is with.
template <typename Ask>
auto ask_primitive(const ContactKey& key, const Ask& ask) noexcept {
  return is_body(key) ? ask(BodyGap{}) : ask(CapsuleGap{});
}

}  // namespace hapticd
