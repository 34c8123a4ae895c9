// See yielding_strings.h. RT: yes.
#include "core/contact/yielding_strings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/contact/clearance.h"
#include "core/contact/stick_anchor.h"
#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// A deflection this small is rest, m: far below the rounding of any contact.
constexpr double kAtRest = 1e-13;
/// Share of a slip that may be off its plane: above the rounding of the plane, far below what is
/// felt.
constexpr double kLaidAcross = 1e-12;
/// How often the return of a string to rest is halved where another tool blocks it.
constexpr int kStraighteningHalvings = 8;
/// Deflections below this have no direction of their own, m: the contact's normal gives it.
constexpr double kDirectionless = 1e-9;

/// Part of `v` across the unit vector `axis`.
Vector3 across(const Vector3& v, const Vector3& axis) noexcept { return v - axis.dot(v) * axis; }

/// The same, but what is off by rounding alone stays to the bit: laid across anew in every tick it
/// would creep.
Vector3 laid_across(const Vector3& v, const Vector3& axis) noexcept {
  const double off = axis.dot(v);
  return std::abs(off) <= kLaidAcross * v.norm() ? v : Vector3(v - off * axis);
}

/// A sphere of the tool that touches a string. `lambda` is of its centre: on a bent string the
/// nearest points lie beside the vertex, on either leg.
struct TouchingSphere {
  Vector3 p_WS;
  double lambda;
};

/// Sums over the contacts of one string.
struct ContactCentre {
  Vector3 p_WC{0.0, 0.0, 0.0};
  Vector3 p_WS{0.0, 0.0, 0.0};
  Vector3 nhat_W{0.0, 0.0, 0.0};
  double lambda = 0.0;
  double weight = 0.0;
  std::array<double, kMaxSoftParts> part_weight;

  void add(const Contact& contact, const TouchingSphere& sphere, double share) noexcept {
    p_WC += share * contact.p_WC;
    p_WS += share * sphere.p_WS;
    nhat_W += share * contact.nhat_OG_W;
    lambda += share * sphere.lambda;
    weight += share;
  }
  /// Of what is added, the weight of a soft part.
  void add_part(int part, double share) noexcept {
    if (part >= 0) part_weight[static_cast<std::size_t>(part)] += share;
  }
};

/// What the search for the centre of a string's contact looks at.
struct TouchSearch {
  const Configuration& at;
  const Capsule& string_W;
  std::int32_t capsule;
  std::span<const Contact* const> contacts;  ///< those with strings
};

TouchingSphere touching_sphere(const TouchSearch& search, const Contact& contact) noexcept {
  const double r = tree_sphere(search.at.input.tool, contact.key.tool_sphere).r;
  const Vector3 p_WS = contact.p_WC + r * contact.nhat_OG_W;
  return {p_WS, closest_point_on_segment(search.string_W.p_A, search.string_W.p_B, p_WS).lambda};
}

/// Where the string is touched: the pairs that carried force, by their force; else the nearest
/// pair, if it is near enough. Weight 0: nowhere.
ContactCentre find_centre(const TouchSearch& search, double near_gap) noexcept {
  const auto& [input, state] = search.at;
  ContactCentre centre;
  for (std::size_t k = 0; k < state.parts.size(); ++k) centre.part_weight[k] = 0.0;
  const Contact* nearest = nullptr;
  for (const Contact* const place : search.contacts) {
    const Contact& contact = *place;
    if (contact.key.obstacle != search.capsule) continue;
    if (nearest == nullptr || contact.gap < nearest->gap) nearest = &contact;
    for (int k = 0; k < state.active_count; ++k) {
      const ActivePair& pair = state.active[static_cast<std::size_t>(k)];
      if (pair.key == contact.key && pair.multiplier > 0.0) {
        centre.add(contact, touching_sphere(search, contact), pair.multiplier);
        centre.add_part(find_part(input.parts, state.parts, pair.key.tool_sphere), pair.multiplier);
      }
    }
  }
  if (!(centre.weight > 0.0) && nearest != nullptr && nearest->gap <= near_gap) {
    centre.add(*nearest, touching_sphere(search, *nearest), 1.0);
    centre.add_part(find_part(input.parts, state.parts, nearest->key.tool_sphere), 1.0);
  }
  return centre;
}

void place_block(const ContactCentre& centre, const ContactState& state,
                 StringBlock& block) noexcept {
  block.touched = centre.weight > 0.0;
  block.p_GC_W = Vector3::Zero();
  block.p_GS_W = Vector3::Zero();
  block.nhat_W = Vector3::Zero();
  block.parts = block.touched ? state.parts.size() : 0;
  if (!block.touched) return;
  for (std::size_t p = 0; p < block.parts; ++p) {
    block.part_share[p] = centre.part_weight[p] / centre.weight;
  }
  block.p_GC_W = centre.p_WC / centre.weight - state.X_WG.p;
  block.p_GS_W = centre.p_WS / centre.weight - state.X_WG.p;
  const double length = centre.nhat_W.norm();
  if (length > 0.0) block.nhat_W = centre.nhat_W / length;
  block.lambda = centre.lambda / centre.weight;
}

bool is_inside(double lambda) noexcept { return lambda > 0.0 && lambda < 1.0; }

/// True where the vertex goes along the string with the tool: no further than its ends.
bool slides(const StringBend& bend, const StringBlock& block) noexcept {
  return block.touched && is_inside(bend.lambda) && is_inside(block.place);
}

/// How the lateral force changes with place and deflection, kept such that U stays convex. With c
/// the compliance in series and K the stiffness of both, the string's own part of the deflection is
/// u - c F, and c takes its share of what changes: 1 - c K of the mixed one.
void set_axial_stiffness(const ContactInput& input, const StringBend& bend, const Deflection& law,
                         StringBlock& block) noexcept {
  block.axial_stiffness = 0.0;
  block.mixed_stiffness = 0.0;
  const StringConstants& string = input.strings[static_cast<std::size_t>(bend.capsule)];
  const double compliance =
      std::max(0.0, 1.0 / string.contact_stiffness - 1.0 / input.stiffness.kt);
  const double u = bend.u_W.norm() - compliance * law.force;
  const double tension = string.tension + law.axial_force;
  if (!(u > kDirectionless && tension > 0.0) || block.lateral_force == 0.0) return;
  const double run_1 = bend.lambda * string.length;
  const double run_2 = (1.0 - bend.lambda) * string.length;
  const double square_1 = run_1 * run_1 + u * u;
  const double square_2 = run_2 * run_2 + u * u;
  const double cube_1 = square_1 * std::sqrt(square_1);
  const double cube_2 = square_2 * std::sqrt(square_2);
  const double cosines = -law.lateral_force / tension;
  const double elastic = string.axial_stiffness / string.length * cosines;
  const double along = elastic * cosines + tension * u * u * (1.0 / cube_1 + 1.0 / cube_2);
  const double mixed =
      elastic * (law.force / tension) - tension * u * (run_1 / cube_1 - run_2 / cube_2);
  const double rigid = std::max(0.0, 1.0 - compliance * law.slope);
  block.axial_stiffness = std::max(0.0, along - compliance * rigid * mixed * mixed);
  const double most = std::sqrt(block.radial_stiffness * block.axial_stiffness);
  block.mixed_stiffness = std::clamp(rigid * mixed, -most, most);
}

void set_law(const ContactInput& input, const TouchedString& string, StringBlock& block) noexcept {
  const double u = string.bend.u_W.norm();
  if (u > kDirectionless) {
    block.radial_W = string.bend.u_W / u;
  } else {
    const Vector3 push =
        block.touched ? Vector3(-across(block.nhat_W, block.axis_W)) : fixed_normal(block.axis_W);
    const double length = push.norm();
    block.radial_W = length > 0.5 ? Vector3(push / length) : fixed_normal(block.axis_W);
  }
  block.tangential_W = block.axis_W.cross(block.radial_W);
  const Deflection law = string_law(input, string.bend, u);
  const double least = kMinStringStiffness * input.stiffness.kt;
  const double greatest = kMaxStringStiffness * input.stiffness.kt;
  // Where the law bends down, next to an end, its tangent promises too little: the secant never
  // overshoots.
  block.radial_stiffness = std::clamp(std::max(law.slope, law.secant), least, greatest);
  block.tangential_stiffness = std::clamp(law.secant, least, greatest);
  block.force = law.force;
  block.energy = law.energy;
  block.lateral_force = slides(string.bend, block) ? law.lateral_force : 0.0;
  set_axial_stiffness(input, string.bend, law, block);
}

/// Turns the normal of a bent string so that it is across both of its legs alike: where halves are
/// unequal their pull together has a part along the axis, which is part of what presses.
void lean_normal(StringBlock& block) noexcept {
  if (!(block.force > 0.0) || block.lateral_force == 0.0) return;
  const Vector3 upright = across(block.nhat_W, block.axis_W);
  const double length = upright.norm();
  if (!(length > 0.5)) return;
  const double lean = -block.lateral_force / block.force * upright.dot(block.radial_W) / length;
  block.steepness = std::sqrt(1.0 + lean * lean);
  block.nhat_W = (upright / length + lean * block.axis_W) / block.steepness;
}

/// With what the last program pressed on the string.
StickAnchor anchor_of(const ContactInput& input, const TouchedString& string) noexcept {
  const auto index = static_cast<std::size_t>(string.bend.capsule);
  return {input.instrument.anchor_stiffness,
          input.strings[index].friction_coefficient * string.normal_force};
}

/// Along the axis where `step` has gone, N: by the deflection that the hand feels.
double lateral_force(const ContactInput& input, const StringBlock& block,
                     const StringMotion& step) noexcept {
  if (block.lateral_force == 0.0) return 0.0;
  const StringBend end = moved(block.bend, step);
  return string_law(input, end, end.u_W.norm()).lateral_force;
}

/// How far the vertex may go towards the centre without changing a gap by more than `room`.
double centring_limit(const StringBend& bend, double off_centre, double room) noexcept {
  const double u = bend.u_W.norm();
  return u > 0.0 ? room * std::min(bend.lambda, 1.0 - bend.lambda) / u : std::abs(off_centre);
}

/// How far the step takes the tool's material point at `p_GC_W` of the contact, m.
Vector3 contact_motion(const StringBlock& block, const Vector3& p_GC_W,
                       const ConfigurationStep& step) noexcept {
  Vector3 motion = step.tool.dp + step.tool.dtheta.cross(p_GC_W);
  for (std::size_t k = 0; k < block.parts; ++k) {
    motion += block.part_share[k] * step.parts[k].dv_W;
  }
  return motion;
}

/// Motion of the tool's material point against the string's at the contact's centre over a step,
/// its tangential part, m.
Vector3 slip_motion(const StringBlock& block, const StringBend& bend, const ConfigurationStep& step,
                    const Vector3& du_W) noexcept {
  const double share = block.unknown < 0 ? 0.0 : deflection_share(bend, block.lambda);
  return across(contact_motion(block, block.p_GC_W, step) - share * du_W, block.nhat_W);
}

bool may_be_touched(const ContactInput& input, const Contact& contact) noexcept {
  if (!is_string(contact.key)) return false;
  const auto index = static_cast<std::size_t>(contact.key.obstacle);
  if (index >= input.strings.size()) return false;
  const StringConstants& string = input.strings[index];
  if (!(string.length > 0.0)) return false;
  return yields(string) ? bends(string) && contact.lambda > 0.0 && contact.lambda < 1.0
                        : input.instrument.friction && string.friction_coefficient > 0.0;
}

/// Inserts in the order of capsules; false when full.
bool insert(const TouchedString& string, TouchedStrings& strings) noexcept {
  if (!strings.push_back(string)) return false;
  for (std::size_t k = strings.size() - 1;
       k > 0 && strings[k].bend.capsule < strings[k - 1].bend.capsule; --k) {
    std::swap(strings[k], strings[k - 1]);
  }
  return true;
}

double nearest_gap(const ContactSet& contacts, std::int32_t capsule) noexcept {
  double gap = std::numeric_limits<double>::infinity();
  for (const Contact& contact : contacts.contacts) {
    if (is_string(contact.key) && contact.key.obstacle == capsule) {
      gap = std::min(gap, contact.gap);
    }
  }
  return gap;
}

/// Lets go of strings that are at rest and out of reach; true when one of them yielded.
bool let_go(const ContactSet& contacts, double skin, TouchedStrings& strings) noexcept {
  bool changed = false;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < strings.size(); ++k) {
    const TouchedString& string = strings[k];
    const bool far =
        nearest_gap(contacts, string.bend.capsule) > 2.0 * kTouchSkins * skin + kAtRest;
    if (far && string.bend.u_W.norm() <= kAtRest) {
      changed = changed || string.yields;
    } else {
      if (kept != k) strings[kept] = string;
      ++kept;
    }
  }
  strings.truncate(kept);
  return changed;
}

}  // namespace

StringMotion string_motion(const StringBlock& block, const StringBend& bend, const Vector3& du_W,
                           const ConfigurationStep& step) noexcept {
  if (block.unknown < 0 || !block.touched) return {du_W, 0.0, 0.0};
  const double along = contact_motion(block, block.p_GS_W, step).dot(block.axis_W) / block.length;
  const double off_centre = block.lambda - bend.lambda;
  const double limit = centring_limit(bend, off_centre, step.centring_room);
  // The tool may leave the vertex behind at an end, and comes back to it there.
  const double way = std::clamp(block.place + along, 0.0, 1.0) - std::clamp(block.place, 0.0, 1.0);
  const double slid = std::clamp(way, -bend.lambda, 1.0 - bend.lambda);
  const double dlambda =
      std::clamp(way + std::clamp(off_centre, -limit, limit), -bend.lambda, 1.0 - bend.lambda);
  return {du_W, dlambda, dlambda - slid};
}

bool YieldingStrings::touch(const ContactInput& input, const ContactSet& contacts,
                            TouchedStrings& strings, int& refused) noexcept {
  const double skin = skin_of(input.options);
  bool changed = let_go(contacts, skin, strings);
  for (const Contact& contact : contacts.contacts) {
    if (contact.gap > kTouchSkins * skin || find_touched(strings, contact.key) >= 0 ||
        !may_be_touched(input, contact)) {
      continue;
    }
    const auto index = static_cast<std::size_t>(contact.key.obstacle);
    TouchedString string;
    string.bend = {contact.key.obstacle, contact.lambda, Vector3::Zero()};
    string.yields = yields(input.strings[index]);
    if (insert(string, strings)) {
      changed = changed || string.yields;
    } else {
      ++refused;
    }
  }
  return changed;
}

void YieldingStrings::relax(const ContactInput& input, TouchedStrings& strings) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; !input.others.tools.empty() && k < strings.size(); ++k) {
    TouchedString string = strings[k];
    if (!string.yields) continue;
    StringMotion motion{-string.bend.u_W, 0.0, 0.0};
    const Capsule& line = input.obstacles.capsules_W[static_cast<std::size_t>(string.bend.capsule)];
    int halving = 0;
    while (halving <= kStraighteningHalvings &&
           !clear_of_other_tools(input.others, line, string.bend, motion)) {
      motion = scaled(motion, 0.5);
      ++halving;
    }
    if (halving == 0) continue;
    if (halving <= kStraighteningHalvings) string.bend = moved(string.bend, motion);
    string.u_felt_W = string.bend.u_W;
    string.normal_force = 0.0;
    string.tangential_W = Vector3::Zero();
    string.slip_W = Vector3::Zero();
    strings[kept++] = string;
  }
  if (kept == 0) {
    strings.clear();
  } else {
    strings.truncate(kept);
  }
}

void YieldingStrings::finish(const ContactInput& input, TouchedStrings& strings) noexcept {
  if (!input.instrument.friction) return;
  for (TouchedString& string : strings) {
    string.slip_W = anchor_of(input, string).left_of(string.slip_W);
  }
}

bool YieldingStrings::clear_of_others(const Configuration& at,
                                      const ConfigurationStep& step) noexcept {
  const auto& [input, state] = at;
  if (input.others.tools.empty()) return true;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& string = state.touched[k];
    if (!string.yields) continue;
    const auto index = static_cast<std::size_t>(string.bend.capsule);
    if (!clear_of_other_tools(input.others, input.obstacles.capsules_W[index], string.bend,
                              step.strings[k])) {
      return false;
    }
  }
  return true;
}

int YieldingStrings::build(const Configuration& at, const ContactSet& contacts,
                           int unknowns) noexcept {
  const auto& [input, state] = at;
  if (state.touched.empty()) return unknowns;
  FixedVector<const Contact*, kMaxCandidates> with_strings;
  for (const Contact& contact : contacts.contacts) {
    if (is_string(contact.key)) with_strings.push_back(&contact);
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& string = state.touched[k];
    StringBlock& block = blocks_[k];
    const auto index = static_cast<std::size_t>(string.bend.capsule);
    const Capsule& capsule = input.obstacles.capsules_W[index];
    block.length = input.strings[index].length;
    block.axis_W = (capsule.p_B - capsule.p_A) / block.length;
    block.lambda = string.bend.lambda;
    block.bend = string.bend;
    place_block(
        find_centre({at, capsule, string.bend.capsule, {with_strings.begin(), with_strings.size()}},
                    2.0 * kTouchSkins * skin_of(input.options)),
        state, block);
    block.unknown = -1;
    block.force = 0.0;
    block.lateral_force = 0.0;
    block.steepness = 1.0;
    block.place = (state.X_WG.p + block.p_GS_W - capsule.p_A).dot(block.axis_W) / block.length;
    if (string.yields) {
      block.unknown = unknowns;
      unknowns += 2;
      set_law(input, string, block);
      if (input.instrument.friction) lean_normal(block);
    }
    // The anchor's spring stays tangential where the contact has turned: it shortens, and gains no
    // energy.
    block.slip_W = laid_across(string.slip_W, block.nhat_W);
    const StickAnchor anchor = anchor_of(input, string);
    const bool holds = input.instrument.friction && block.touched;
    block.slip_stiffness = holds ? anchor.stiffness_at(block.slip_W.norm()) : 0.0;
    block.slipping_W = anchor.slipping(block.slip_W);
  }
  return unknowns;
}

void YieldingStrings::measure(const ContactState& state, UnknownScale& scale) const noexcept {
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    if (blocks_[k].unknown < 0) continue;
    const auto first = static_cast<std::size_t>(blocks_[k].unknown);
    scale.inverse_root[first] = 1.0 / std::sqrt(blocks_[k].radial_stiffness);
    scale.inverse_root[first + 1] = 1.0 / std::sqrt(blocks_[k].tangential_stiffness);
    scale.downhill[first] = -blocks_[k].force;
    scale.downhill[first + 1] = 0.0;
  }
}

void YieldingStrings::read_step(const Configuration& at, const Unknowns& y,
                                ConfigurationStep& step) const noexcept {
  for (std::size_t k = 0; k < at.state.touched.size(); ++k) {
    const StringBlock& block = blocks_[k];
    if (block.unknown < 0) {
      step.strings[k] = {Vector3::Zero(), 0.0, 0.0};
      continue;
    }
    const auto u = static_cast<std::size_t>(block.unknown);
    const Vector3 du_W = y[u] * block.radial_W + y[u + 1] * block.tangential_W;
    step.strings[k] = string_motion(block, at.state.touched[k].bend, du_W, step);
  }
}

double YieldingStrings::travel(const Configuration& at, const ConfigurationStep& step) noexcept {
  double travel = 0.0;
  for (std::size_t k = 0; k < at.state.touched.size(); ++k) {
    const auto index = static_cast<std::size_t>(at.state.touched[k].bend.capsule);
    travel = std::max(travel, displacement_bound(step.strings[k], at.input.strings[index].length));
  }
  return travel;
}

// Elastic energy at the old and the new place of the vertex, and friction.
double YieldingStrings::energy_gain(const Configuration& at,
                                    const ConfigurationStep& step) const noexcept {
  const auto& [input, state] = at;
  double gain = 0.0;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& string = state.touched[k];
    const StringMotion& motion = step.strings[k];
    const StringBlock& block = blocks_[k];
    if (string.yields) {
      const StringBend end = moved(string.bend, motion);
      gain += string_law(input, end, end.u_W.norm()).energy - block.energy;
    }
    if (block.slip_stiffness > 0.0) {
      const StickAnchor anchor = anchor_of(input, string);
      const Vector3 slip = block.slip_W + slip_motion(block, string.bend, step, motion.du_W);
      gain += anchor.energy(slip.norm()) - anchor.energy(block.slip_W.norm());
    }
  }
  return gain;
}

void YieldingStrings::add_stored_energy(const Configuration& at, double& energy) const noexcept {
  for (std::size_t k = 0; k < at.state.touched.size(); ++k) {
    const TouchedString& string = at.state.touched[k];
    if (string.yields) energy += blocks_[k].energy;
    energy += 0.5 * blocks_[k].slip_stiffness * blocks_[k].slip_W.squaredNorm();
  }
}

void YieldingStrings::commit(const ContactInput& input, const ConfigurationStep& step,
                             ContactState& state) const noexcept {
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    TouchedString& string = state.touched[k];
    const StringBlock& block = blocks_[k];
    if (input.instrument.friction && block.touched) {
      string.slip_W = block.slip_W + slip_motion(block, string.bend, step, step.strings[k].du_W);
    }
    string.bend = moved(string.bend, step.strings[k]);
  }
}

// On a leg the normal leans along the axis by n_ax. When the centre of the contact slides by dx the
// vertex goes along; the leg's place at the contact then moves by -n_ax share dx along the normal.
GapGradient YieldingStrings::gradient(const ContactState& state,
                                      const Contact& contact) const noexcept {
  const Vector3& n = contact.nhat_OG_W;
  GapGradient gradient{n, (contact.p_WC - state.X_WG.p).cross(n),
                       find_touched(state.touched, contact.key)};
  if (gradient.string < 0) return gradient;
  const StringBlock& block = blocks_[static_cast<std::size_t>(gradient.string)];
  const StringBend& bend = state.touched[static_cast<std::size_t>(gradient.string)].bend;
  const bool on_cap = contact.lambda <= 0.0 || contact.lambda >= 1.0;
  if (block.unknown < 0 || !slides(bend, block) || on_cap) return gradient;
  gradient.slid = deflection_share(bend, contact.lambda) * n.dot(block.axis_W);
  gradient.linear -= gradient.slid * block.axis_W;
  gradient.angular -= gradient.slid * block.p_GS_W.cross(block.axis_W);
  return gradient;
}

Vector3 YieldingStrings::part_gradient(const Contact& contact, const GapGradient& gradient,
                                       std::size_t part, bool own) const noexcept {
  Vector3 out = own ? contact.nhat_OG_W : Vector3(0.0, 0.0, 0.0);
  if (gradient.slid == 0.0) return out;
  const StringBlock& block = blocks_[static_cast<std::size_t>(gradient.string)];
  out -= (gradient.slid * block.part_share[part]) * block.axis_W;
  return out;
}

// Friction is held by what the string gives, not by what the program presses on it.
void YieldingStrings::settle(const ContactInput& input, std::span<const StringSum> sums,
                             const ConfigurationStep& step, ContactState& state) const noexcept {
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    TouchedString& string = state.touched[k];
    if (string.yields) string.u_felt_W = blocks_[k].bend.u_W + step.strings[k].du_W;
    string.normal_force = 0.0;
    if (!input.instrument.friction) continue;
    string.normal_force = sums[k].beside;
    if (!(sums[k].multiplier > 0.0)) continue;
    const double lambda = sums[k].lambda / sums[k].multiplier;
    string.normal_force +=
        blocks_[k].steepness *
        string_load(input, &string, {string.bend.capsule, lambda, sums[k].f_W}).force;
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const StringBlock& block = blocks_[k];
    TouchedString& string = state.touched[k];
    string.tangential_W = Vector3::Zero();
    if (!block.touched) continue;
    string.tangential_W = lateral_force(input, block, step.strings[k]) * block.axis_W;
    state.F_H_W.f += string.tangential_W;
    state.F_H_W.t += block.p_GS_W.cross(string.tangential_W);
    if (!input.instrument.friction) continue;
    const Vector3 f =
        anchor_of(input, string)
            .force(block.slip_W + slip_motion(block, block.bend, step, step.strings[k].du_W));
    string.tangential_W += f;
    state.F_H_W.f += f;
    state.F_H_W.t += block.p_GC_W.cross(f);
  }
}

}  // namespace hapticd
