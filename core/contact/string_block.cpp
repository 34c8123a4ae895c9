// Directions, stiffnesses and contact centres of held strings. See string_block.h. RT: yes.
#include "core/contact/string_block.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// Deflections below this have no direction of their own, m: the contact's normal gives it.
constexpr double kDirectionless = 1e-9;

/// Part of `v` across the unit vector `axis`.
Vector3 across(const Vector3& v, const Vector3& axis) noexcept { return v - axis.dot(v) * axis; }

/// Sums over the contacts of one string.
struct ContactCentre {
  Vector3 p_WC{0.0, 0.0, 0.0};
  Vector3 nhat_W{0.0, 0.0, 0.0};
  double lambda = 0.0;
  double weight = 0.0;
  std::array<double, kMaxSoftParts> part_weight;

  /// `lambda` is that of the tool sphere's centre: on a bent string the nearest points of a sphere
  /// lie beside its vertex, on either leg.
  void add(const Contact& contact, double lambda_of_sphere, double share) noexcept {
    p_WC += share * contact.p_WC;
    nhat_W += share * contact.nhat_OG_W;
    lambda += share * lambda_of_sphere;
    weight += share;
  }
  /// Of what is added, the weight of a soft part.
  void add_part(int part, double share) noexcept {
    if (part >= 0) part_weight[static_cast<std::size_t>(part)] += share;
  }
};

/// What the search for the centre of a string's contact looks at.
struct TouchContext {
  const SphereTreeView& tool;
  const ToolParts& parts;
  const Capsule& string_W;
  std::span<const Contact* const> contacts;  ///< those with strings
  const ContactState& state;
};

double lambda_of_sphere(const TouchContext& touch, const Contact& contact) noexcept {
  const double r = tree_sphere(touch.tool, contact.key.tool_sphere).r;
  return closest_point_on_segment(touch.string_W.p_A, touch.string_W.p_B,
                                  contact.p_WC + r * contact.nhat_OG_W)
      .lambda;
}

/// Where the string is touched: the pairs that carried force, by their force; else the nearest
/// pair, if it is near enough. Weight 0: nowhere.
ContactCentre find_centre(const TouchContext& touch, std::int32_t capsule,
                          double near_gap) noexcept {
  ContactCentre centre;
  const SoftParts& soft = touch.state.parts;
  for (std::size_t k = 0; k < soft.size(); ++k) centre.part_weight[k] = 0.0;
  const Contact* nearest = nullptr;
  for (const Contact* const place : touch.contacts) {
    const Contact& contact = *place;
    if (contact.key.obstacle != capsule) continue;
    if (nearest == nullptr || contact.gap < nearest->gap) nearest = &contact;
    for (int k = 0; k < touch.state.active_count; ++k) {
      const ActivePair& pair = touch.state.active[static_cast<std::size_t>(k)];
      if (pair.key == contact.key && pair.multiplier > 0.0) {
        centre.add(contact, lambda_of_sphere(touch, contact), pair.multiplier);
        centre.add_part(find_part(touch.parts, soft, pair.key.tool_sphere), pair.multiplier);
      }
    }
  }
  if (!(centre.weight > 0.0) && nearest != nullptr && nearest->gap <= near_gap) {
    centre.add(*nearest, lambda_of_sphere(touch, *nearest), 1.0);
    centre.add_part(find_part(touch.parts, soft, nearest->key.tool_sphere), 1.0);
  }
  return centre;
}

void model_law(const StringContext& context, const TouchedString& hold,
               StringBlock& model) noexcept {
  const double u = hold.bend.u_W.norm();
  if (u > kDirectionless) {
    model.radial_W = hold.bend.u_W / u;
  } else {
    const Vector3 push =
        model.touched ? Vector3(-across(model.nhat_W, model.axis_W)) : fixed_normal(model.axis_W);
    const double length = push.norm();
    model.radial_W = length > 0.5 ? Vector3(push / length) : fixed_normal(model.axis_W);
  }
  model.tangential_W = model.axis_W.cross(model.radial_W);
  const Deflection law = string_law(context, hold.bend, u);
  const double least = kMinStringStiffness * context.kt;
  const double greatest = kMaxStringStiffness * context.kt;
  // Where the law bends down, next to an end, its tangent promises too little: the secant never
  // overshoots.
  model.radial_stiffness = std::clamp(std::max(law.slope, law.secant), least, greatest);
  model.tangential_stiffness = std::clamp(law.secant, least, greatest);
  model.force = law.force;
  model.lateral_force = context.options.lateral_force && model.touched ? law.lateral_force : 0.0;
}

/// Stiffness of the friction spring: its own while it sticks, what leads to mu N while it slips.
double slip_stiffness(const StringContext& context, const TouchedString& hold,
                      const Vector3& slip_W) noexcept {
  const auto index = static_cast<std::size_t>(hold.bend.capsule);
  const double limit = context.strings[index].friction_coefficient * hold.normal_force;
  const double slip = slip_W.norm();
  const double stiffness = context.options.anchor_stiffness;
  if (!(limit > 0.0)) return 0.0;
  return stiffness * slip <= limit ? stiffness : limit / slip;
}

/// How far the vertex may go towards the centre without changing a gap by more than `room`.
double centring_limit(const StringBend& bend, double off_centre, double room) noexcept {
  const double u = bend.u_W.norm();
  return u > 0.0 ? room * std::min(bend.lambda, 1.0 - bend.lambda) / u : std::abs(off_centre);
}

}  // namespace

int model_strings(const ContactInput& input, const ContactSet& contacts, const ContactState& state,
                  int unknowns, StringBlocks& models) noexcept {
  const StringContext context = string_context(input);
  FixedVector<const Contact*, kMaxCandidates> with_strings;
  for (const Contact& contact : contacts.contacts) {
    if (contact.key.kind == ObstacleKind::kCapsule) with_strings.push_back(&contact);
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const TouchedString& hold = state.touched[k];
    StringBlock& model = models[k];
    const auto index = static_cast<std::size_t>(hold.bend.capsule);
    const Capsule& capsule = context.obstacles.capsules_W[index];
    model.length = context.strings[index].length;
    model.axis_W = (capsule.p_B - capsule.p_A) / model.length;
    const ContactCentre centre = find_centre(
        {input.tool, input.parts, capsule, {with_strings.begin(), with_strings.size()}, state},
        hold.bend.capsule, 2.0 * kTouchSkins * input.options.skin);
    model.touched = centre.weight > 0.0;
    model.p_GC_W = Vector3::Zero();
    model.nhat_W = Vector3::Zero();
    model.lambda = hold.bend.lambda;
    model.parts = model.touched ? state.parts.size() : 0;
    if (model.touched) {
      for (std::size_t p = 0; p < model.parts; ++p) {
        model.part_share[p] = centre.part_weight[p] / centre.weight;
      }
      model.p_GC_W = centre.p_WC / centre.weight - state.X_WG.p;
      const double length = centre.nhat_W.norm();
      if (length > 0.0) model.nhat_W = centre.nhat_W / length;
      model.lambda = centre.lambda / centre.weight;
    }
    model.unknown = -1;
    model.force = 0.0;
    model.lateral_force = 0.0;
    if (hold.yields) {
      model.unknown = unknowns;
      unknowns += 2;
      model_law(context, hold, model);
    }
    // The anchor's spring stays tangential where the contact has turned: it shortens, and gains no
    // energy.
    model.slip_W = across(hold.slip_W, model.nhat_W);
    model.slip_stiffness = context.options.friction && model.touched
                               ? slip_stiffness(context, hold, model.slip_W)
                               : 0.0;
  }
  return unknowns;
}

// On a leg the normal leans along the axis by n_ax. When the centre of the contact slides by dx the
// vertex goes along; the leg's place at the contact then moves by -n_ax share dx along the normal.
GapGradient gap_gradient(const ContactState& state, const StringBlocks& models,
                         const Contact& contact) noexcept {
  const Vector3& n = contact.nhat_OG_W;
  GapGradient gradient{n, (contact.p_WC - state.X_WG.p).cross(n),
                       find_touched(state.touched, contact.key)};
  if (gradient.hold < 0) return gradient;
  const StringBlock& model = models[static_cast<std::size_t>(gradient.hold)];
  const StringBend& bend = state.touched[static_cast<std::size_t>(gradient.hold)].bend;
  const bool on_cap = contact.lambda <= 0.0 || contact.lambda >= 1.0;
  const bool at_end = bend.lambda <= 0.0 || bend.lambda >= 1.0;
  if (model.unknown < 0 || !model.touched || on_cap || at_end) return gradient;
  gradient.slid = deflection_share(bend, contact.lambda) * n.dot(model.axis_W);
  gradient.linear -= gradient.slid * model.axis_W;
  gradient.angular -= gradient.slid * model.p_GC_W.cross(model.axis_W);
  return gradient;
}

Vector3 part_gradient(const StringBlocks& models, const Contact& contact,
                      const GapGradient& gradient, std::size_t part, bool own) noexcept {
  Vector3 out = own ? contact.nhat_OG_W : Vector3(0.0, 0.0, 0.0);
  if (gradient.slid == 0.0) return out;
  const StringBlock& model = models[static_cast<std::size_t>(gradient.hold)];
  out -= (gradient.slid * model.part_share[part]) * model.axis_W;
  return out;
}

Vector3 contact_motion(const StringBlock& model, const ConfigurationStep& step) noexcept {
  Vector3 motion = step.tool.dp + step.tool.dtheta.cross(model.p_GC_W);
  for (std::size_t k = 0; k < model.parts; ++k) {
    motion += model.part_share[k] * step.parts[k].dv_W;
  }
  return motion;
}

StringMotion string_motion(const StringBlock& model, const StringBend& bend,
                           const ConfigurationStep& step, const Vector3& du_W,
                           double room) noexcept {
  if (model.unknown < 0 || !model.touched) return {du_W, 0.0, 0.0};
  const double along = contact_motion(model, step).dot(model.axis_W) / model.length;
  const double off_centre = model.lambda - bend.lambda;
  const double limit = centring_limit(bend, off_centre, room);
  const double slid = std::clamp(along, -bend.lambda, 1.0 - bend.lambda);
  const double dlambda =
      std::clamp(along + std::clamp(off_centre, -limit, limit), -bend.lambda, 1.0 - bend.lambda);
  return {du_W, dlambda, dlambda - slid};
}

Vector3 slip_motion(const StringBlock& model, const StringBend& bend, const ConfigurationStep& step,
                    const Vector3& du_W) noexcept {
  const double share = model.unknown < 0 ? 0.0 : deflection_share(bend, model.lambda);
  return across(contact_motion(model, step) - share * du_W, model.nhat_W);
}

}  // namespace hapticd
